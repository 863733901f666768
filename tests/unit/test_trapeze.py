"""Second-order strains of a twisted section, from stresses of the elementary theory of bars."""

import numpy as np
import pytest

from plymotion.solver.package.common.recovery_schema import SectionRecovery
from plymotion.solver.package.section.stress import trapeze_strains

# Four stiff strips around a soft core: no symmetry. Positions, areas, moduli along the bar.
POINTS = np.array([[0.02, 0.01], [-0.03, 0.005], [0.01, -0.02], [-0.01, 0.015], [0.0, 0.0]])
AREAS = np.array([2e-4, 1e-4, 3e-4, 1.5e-4, 5e-4])
MODULI = np.array([70e9, 120e9, 40e9, 200e9, 1e9])
SHEAR_CENTRE = np.array([0.004, -0.007])


def bar(
    points: np.ndarray, centre: np.ndarray, angle: float = 0.0
) -> tuple[np.ndarray, SectionRecovery]:
    """Stiffness and stresses of the strips; fibres that are turned by `angle` in their plies."""
    axial = np.column_stack([np.ones(len(points)), points[:, 1], -points[:, 0]])
    inner = np.einsum("p,pi,pj->ij", AREAS * MODULI, axial, axial)
    S = np.zeros((6, 6))
    kept = [0, 4, 5]
    S[np.ix_(kept, kept)] = np.linalg.inv(inner)
    shear = 1e-7 * np.array([[1.0, 0.2], [0.2, 1.5]])
    twist = 2e-3  # twist and the displacement of the reference line about the shear centre
    arm = np.array([centre[1], -centre[0]])
    S[1:3, 1:3] = shear + twist * np.outer(arm, arm)
    S[1:3, 3] = S[3, 1:3] = twist * arm
    S[3, 3] = twist
    strain = np.zeros((len(points), 6, 6))
    strain[:, 0] = axial @ S[kept]  # uniaxial: the modulus is the only stiffness
    C = np.zeros((len(points), 6, 6))
    C[:, 0, 0] = MODULI
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    if angle:  # the same axial stress, in the axes of turned plies
        c, s = np.cos(angle), np.sin(angle)
        stress = MODULI[:, None] * strain[:, 0]
        C = np.tile(np.eye(6), (len(points), 1, 1))
        strain[:, 0], strain[:, 1], strain[:, 5] = c * c * stress, s * s * stress, -c * s * stress
    recovery = SectionRecovery(
        points=points,
        weights=AREAS,
        cell=np.arange(len(points)),
        ply=np.arange(len(points)),
        A_BM=np.tile(turn, (len(points), 1, 1)),
        strain_M=strain,
        C_M=C,
        plies=(),
        materials={},
    )
    return np.linalg.inv(S), recovery


@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_strains_without_resultants(angle: float) -> None:
    """a = F Q: the fibre strains 1/2 r^2 about the shear centre, minus a, carry no load."""
    found = trapeze_strains(*bar(POINTS, SHEAR_CENTRE, angle))
    assert np.abs(found[1:4]).max() < 1e-12 * found[0]
    r2 = ((POINTS - SHEAR_CENTRE) ** 2).sum(axis=1)
    y, z = POINTS.T
    left = r2 - found[0] - z * found[4] + y * found[5]
    load = AREAS * MODULI * left
    for lever in (np.ones(5), y, z):
        assert abs(load @ lever) < 1e-12 * np.abs(AREAS * MODULI * r2 * lever).sum()


def test_strains_do_not_depend_on_the_reference_line() -> None:
    """Except for the extension of the line, which changes with the curvatures."""
    shift = np.array([0.05, -0.03])
    one = trapeze_strains(*bar(POINTS, SHEAR_CENTRE))
    two = trapeze_strains(*bar(POINTS + shift, SHEAR_CENTRE + shift))
    np.testing.assert_allclose(two[4:], one[4:], rtol=1e-10)
    # the fibre at the old line has the old extension
    assert two[0] + shift[1] * two[4] - shift[0] * two[5] == pytest.approx(one[0], rel=1e-9)
    assert np.abs(one[4:]).min() > 1e-3


def test_section_of_one_material_has_its_radius_of_gyration() -> None:
    width, height = 0.03, 0.004
    x, w = np.polynomial.legendre.leggauss(2)
    y, z = (half.ravel() for half in np.meshgrid(width / 2 * x, height / 2 * x))
    area = np.outer(w, w).ravel() * width * height / 4
    A, I2, I3 = width * height, width * height**3 / 12, height * width**3 / 12
    strain = np.zeros((4, 6, 6))
    strain[:, 0, [0, 4, 5]] = np.column_stack([np.full(4, 1 / A), z / I2, -y / I3])
    number = np.arange(4)
    recovery = SectionRecovery(
        points=np.column_stack([y, z]),
        weights=area,
        cell=number,
        ply=0 * number,
        A_BM=np.tile(np.eye(3), (4, 1, 1)),
        strain_M=strain,
        C_M=np.eye(6)[None],
        plies=(),
        materials={},
    )
    found = trapeze_strains(np.eye(6), recovery)
    expected = [(width**2 + height**2) / 12, 0.0, 0.0, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(found, expected, atol=1e-16)
