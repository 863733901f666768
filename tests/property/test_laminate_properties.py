"""What holds for every laminate: parallel axes, turning, mirroring, positive energy."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from samples.laminate_samples import ALUMINIUM, CFRP, FOAM, GLASS

from plymotion.preprocess.laminate.stiffness import (
    CORRECTIONS,
    Lamina,
    Laminate,
    laminate_stiffness,
)

lamina = st.builds(
    Lamina,
    st.sampled_from([CFRP, GLASS, ALUMINIUM, FOAM]),
    st.floats(-90.0, 90.0),
    st.floats(1e-4, 5e-3),
)
laminates = st.lists(lamina, min_size=1, max_size=8).map(lambda plies: Laminate(tuple(plies)))
corrections = st.sampled_from(CORRECTIONS)
EXAMPLES = settings(max_examples=60, deadline=None)


@EXAMPLES
@given(laminates, st.floats(-0.01, 0.01), corrections)
def test_an_offset_moves_the_axes_parallel(laminate: Laminate, z: float, shear: str) -> None:
    """B' = B + z A, D' = D + 2 z B + z^2 A; A and the shear stiffness stay."""
    here = laminate_stiffness(laminate, shear)
    there = laminate_stiffness(replace(laminate, offset=z), shear)
    size, reach = np.max(here.A), laminate.thickness + abs(z)
    np.testing.assert_allclose(there.A, here.A, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(there.B, here.B + z * here.A, rtol=0, atol=1e-13 * size * reach)
    np.testing.assert_allclose(
        there.D, here.D + 2 * z * here.B + z**2 * here.A, rtol=0, atol=1e-13 * size * reach**2
    )
    m0, m1, m2 = here.mass
    np.testing.assert_allclose(
        there.mass / [1, reach, reach**2],
        np.array([m0, m1 + z * m0, m2 + 2 * z * m1 + z**2 * m0]) / [1, reach, reach**2],
        rtol=0,
        atol=1e-13 * m0,
    )
    loss = 1e-9 * (reach / laminate.thickness) ** 4  # digits lost by going there and back
    np.testing.assert_allclose(there.Ds, here.Ds, rtol=0, atol=loss * np.max(here.Ds))


@EXAMPLES
@given(laminates, corrections)
def test_turning_the_laminate_by_90_deg_swaps_the_axes(laminate: Laminate, shear: str) -> None:
    turned = Laminate(tuple(ply._replace(angle_deg=ply.angle_deg + 90) for ply in laminate.plies))
    here, there = laminate_stiffness(laminate, shear), laminate_stiffness(turned, shear)
    swap = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
    swap_shear = np.array([[0, -1], [1, 0]])
    for key in ("A", "B", "D"):
        one, other = getattr(here, key), getattr(there, key)
        size = np.max(here.A) * laminate.thickness ** "ABD".index(key)
        np.testing.assert_allclose(other, swap @ one @ swap, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(
        there.Ds, swap_shear @ here.Ds @ swap_shear.T, rtol=0, atol=1e-9 * np.max(here.Ds)
    )


@EXAMPLES
@given(laminates, st.floats(-0.005, 0.005), corrections)
def test_every_deformation_takes_energy(laminate: Laminate, z: float, shear: str) -> None:
    found = laminate_stiffness(replace(laminate, offset=z), shear)
    h = laminate.thickness
    scale = np.repeat([1.0, 1.0 / h], 3)  # curvature times thickness is a strain
    ABD = found.ABD * np.outer(scale, scale)
    np.testing.assert_array_equal(ABD, ABD.T)
    assert np.linalg.eigvalsh(ABD)[0] > 0.0
    assert np.linalg.eigvalsh(found.Ds)[0] > 0.0
    np.testing.assert_array_equal(found.Ds, found.Ds.T)


@EXAMPLES
@given(laminates, corrections)
def test_seen_from_below(laminate: Laminate, shear: str) -> None:
    """The plies in reverse order at the opposite angle: e2 and e3 are turned over together."""
    below = Laminate(
        tuple(ply._replace(angle_deg=-ply.angle_deg) for ply in reversed(laminate.plies))
    )
    here, there = laminate_stiffness(laminate, shear), laminate_stiffness(below, shear)
    # about e1 by 180 deg: gxy changes sign, and every curvature once more
    sign = np.diag([1.0, 1.0, -1.0])
    size, h = np.max(here.A), laminate.thickness
    np.testing.assert_allclose(there.A, sign @ here.A @ sign, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(there.B, -sign @ here.B @ sign, rtol=0, atol=1e-13 * size * h)
    np.testing.assert_allclose(there.D, sign @ here.D @ sign, rtol=0, atol=1e-13 * size * h**2)
    shear_sign = np.diag([1.0, -1.0])  # with w and z reversed: gxz stays but for both signs
    np.testing.assert_allclose(
        there.Ds, shear_sign @ here.Ds @ shear_sign, rtol=0, atol=1e-9 * np.max(here.Ds)
    )
