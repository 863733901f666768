"""Laminates: plane stress, pairing of the moments, mass, ply stresses, report, messages."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from samples.laminate_samples import ALUMINIUM, CFRP, FOAM, GLASS, hybrid, stack

from plymotion.preprocess.laminate.laminate_specification import laminate_from_dict
from plymotion.preprocess.laminate.report import report
from plymotion.preprocess.laminate.stiffness import (
    Lamina,
    Laminate,
    LaminateError,
    equilibrium_shear,
    laminate_stiffness,
    shear_factors,
    strain_stress_at,
    stress_operators,
)
from plymotion.solver.package.common.materials import isotropic


def test_isotropic_plate_is_the_textbook_one() -> None:
    E, nu, rho, h = 70e9, 0.3, 2700.0, 2e-3
    s = laminate_stiffness(Laminate((Lamina(isotropic(E, nu, rho), 33.0, h),)), "5/6")
    plane = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    np.testing.assert_allclose(s.A, plane * h, rtol=1e-12, atol=1e-12 * E * h)
    np.testing.assert_allclose(s.B, 0, atol=1e-12 * E * h**2)
    np.testing.assert_allclose(s.D, plane * h**3 / 12, rtol=1e-12, atol=1e-12 * E * h**3)
    G = E / (2 * (1 + nu))
    np.testing.assert_allclose(s.Ds, 5 / 6 * G * h * np.eye(2), rtol=1e-12, atol=1e-9 * G * h)
    np.testing.assert_allclose(s.mass, [rho * h, 0, rho * h**3 / 12], atol=1e-15)
    assert s.thickness == h


def test_printed_pairing_of_eq_29_gives_a_plate_without_bending_stiffness() -> None:
    """H_2 about the middle of a plate is 0: D_b with H_2, as printed, is then 0."""

    plate = stack(0.0, 90.0, 90.0, 0.0)
    H = plate.moments
    as_printed = np.einsum("k,kij->ij", H[1], plate.plane)
    D = laminate_stiffness(plate).D
    assert np.max(np.abs(as_printed)) < 1e-12 * np.max(plate.plane) * plate.thickness**2
    # and the correct pairing is the sum of the bending stiffness of the plies: sum E int z^2
    z = np.linspace(plate.faces[0], plate.faces[-1], 40001)
    z = 0.5 * (z[1:] + z[:-1])
    ply = np.searchsorted(plate.faces, z) - 1
    work = np.sum(plate.plane[ply, 0, 0] * z**2) * plate.thickness / len(z)
    assert D[0, 0] == pytest.approx(work, rel=1e-8)


def test_printed_coefficients_of_eq_29_are_not_plane_stress() -> None:
    """c_11 of (18) holds eps_33 = 0: a free strip of aluminium would not have E as its modulus."""
    plate = Laminate((Lamina(ALUMINIUM, 0.0, 1e-3),))
    a = np.linalg.inv(laminate_stiffness(plate).A)
    assert 1.0 / (a[0, 0] * 1e-3) == pytest.approx(70e9, rel=1e-12)
    printed = plate.stiffness[0][np.ix_([0, 1, 5], [0, 1, 5])]
    assert 1.0 / np.linalg.inv(printed)[0, 0] > 1.09 * 70e9


def test_mass_of_a_sandwich_on_its_bottom_face() -> None:
    faces, core = 0.5e-3, 10e-3
    plies = (Lamina(ALUMINIUM, 0, faces), Lamina(FOAM, 0, core), Lamina(GLASS, 0, 2 * faces))
    h = core + 3 * faces
    m = laminate_stiffness(Laminate(plies, offset=h / 2)).mass
    z, expected = 0.0, np.zeros(3)
    for material, _, t in plies:
        top = z + t
        expected += material.rho * np.array([top - z, (top**2 - z**2) / 2, (top**3 - z**3) / 3])
        z = top
    np.testing.assert_allclose(m, expected, rtol=1e-12)


def test_factors_of_the_user_and_five_sixths() -> None:
    laminate = hybrid()
    plain = laminate_stiffness(laminate, (1.0, 1.0)).Ds
    own = laminate_stiffness(laminate, (0.5, 0.8)).Ds
    np.testing.assert_allclose(own, plain * np.sqrt(np.outer([0.5, 0.8], [0.5, 0.8])), rtol=1e-14)
    np.testing.assert_allclose(laminate_stiffness(laminate, "5/6").Ds, plain * 5 / 6, rtol=1e-14)


def test_sandwich_shears_like_its_core() -> None:
    """Stiff thin faces, soft core: T = G_core (h_core + t)^2 / h_core gamma, within 2 %."""
    t, c = 0.5e-3, 20e-3
    plies = (Lamina(ALUMINIUM, 0, t), Lamina(FOAM, 0, c), Lamina(ALUMINIUM, 0, t))
    G = 70e6 / 2.6
    for method in ("energy-1d", "energy-2x2"):
        Ds = laminate_stiffness(Laminate(plies), method).Ds
        assert Ds[0, 0] == pytest.approx(G * (c + t) ** 2 / c, rel=0.02)


@pytest.mark.parametrize("laminate", [stack(0.0, 90.0), stack(30.0), hybrid()])
def test_equilibrium_shear_carries_the_force_and_leaves_the_faces(laminate: Laminate) -> None:
    points, weights = np.polynomial.legendre.leggauss(3)
    tau = equilibrium_shear(laminate, 0.5 * (1 + points))
    dz = np.diff(laminate.faces)
    total = np.einsum("k,q,kqij->ij", dz, 0.5 * weights, tau)
    np.testing.assert_allclose(total, np.eye(2), atol=1e-12)
    ends = equilibrium_shear(laminate, np.array([0.0, 1.0]))
    size = np.max(np.abs(tau))
    np.testing.assert_allclose(ends[0, 0], 0, atol=1e-12 * size)
    np.testing.assert_allclose(ends[-1, 1], 0, atol=1e-12 * size)
    np.testing.assert_allclose(ends[1:, 0], ends[:-1, 1], atol=1e-12 * size)


def test_parabola_of_a_homogeneous_plate() -> None:
    h = 3e-3
    tau = equilibrium_shear(Laminate((Lamina(ALUMINIUM, 0, h),)), np.array([0.0, 0.25, 0.5, 1.0]))
    np.testing.assert_allclose(tau[0, :, 0, 0], np.array([0, 0.75, 1, 0]) * 1.5 / h, atol=1e-10 / h)


def test_ply_stresses_add_up_to_the_resultants() -> None:
    """Rotated back to laminate axes and integrated, they are N, M and T."""
    from plymotion.solver.package.common.materials import bond, ply_rotation

    laminate = replace(hybrid(), offset=1e-3)
    points, weights = np.polynomial.legendre.leggauss(3)
    height = 0.5 * (1 + points)
    per_strain = strain_stress_at(laminate, height)
    compliance = np.linalg.inv(laminate_stiffness(laminate).ABD)
    per_strain[..., :6] = per_strain[..., :6] @ compliance
    A = np.array([ply_rotation(ply.angle_deg) for ply in laminate.plies])
    stress = bond(A)[:, None] @ per_strain
    dz = np.diff(laminate.faces)
    z = laminate.faces[:-1, None] + dz[:, None] * height
    w = dz[:, None] * 0.5 * weights
    N = np.einsum("kq,kqij->ij", w, stress)[[0, 1, 5]]
    M = np.einsum("kq,kqij->ij", w * z, stress)[[0, 1, 5]]
    T = np.einsum("kq,kqij->ij", w, stress)[[4, 3]]
    h = laminate.thickness
    scale = np.repeat([1.0, 1 / h, 1.0], [3, 3, 2])  # one size for N, M / h and T
    ours = np.vstack([N, M / h, T]) / scale
    np.testing.assert_allclose(ours, np.eye(8), atol=1e-9)


def test_stress_operators_of_a_single_off_axis_ply() -> None:
    """N = (1, 0, 0) along e1 of fibres at 30 deg: cos^2, sin^2, - sin cos, over the thickness."""
    h, a = 2e-3, np.radians(30.0)
    stress = stress_operators(Laminate((Lamina(CFRP, 30.0, h),)))[0, :, :, 0] * h
    expected = [np.cos(a) ** 2, np.sin(a) ** 2, 0, 0, 0, -np.sin(a) * np.cos(a)]
    np.testing.assert_allclose(stress, np.tile(expected, (3, 1)), atol=1e-12)


@pytest.mark.provokes("laminate-unsymmetric", "laminate-unbalanced")
@pytest.mark.parametrize(
    ("angles", "symmetric", "balanced"),
    [
        ((0, 90, 90, 0), True, True),
        ((0, 90), False, True),
        ((45, -45), False, True),
        ((45, -45, -45, 45), True, True),
        ((30, 30), True, False),
        ((90, -90), True, True),
        ((135, -45), True, False),
        ((60, 0, -60), False, True),
    ],
)
def test_report_of_lay_ups(angles: tuple[float, ...], symmetric: bool, balanced: bool) -> None:
    found = report(stack(*map(float, angles)))
    assert (found.symmetric, found.balanced) == (symmetric, balanced)
    codes = {finding["code"] for finding in found.findings}
    assert ("laminate-unsymmetric" in codes) == (not symmetric)
    assert ("laminate-unbalanced" in codes) == (not balanced)


def test_report_does_not_call_an_offset_unsymmetric() -> None:
    found = report(replace(stack(0.0, 90.0, 0.0), offset=1e-3))
    assert found.symmetric
    assert found.coupling < 1e-12


def test_report_gives_the_constants_of_the_ply() -> None:
    found = report(stack(0.0, 0.0, 0.0))
    expected = {"Ex": CFRP.E1, "Ey": CFRP.E2, "Gxy": CFRP.G12, "nuxy": CFRP.nu12}
    for key, value in expected.items():
        assert found.membrane[key] == pytest.approx(value, rel=1e-10)
        assert found.bending[key] == pytest.approx(value, rel=1e-10)


@pytest.mark.provokes("laminate-soft-core")
@pytest.mark.parametrize(
    ("shear", "warns"),
    [
        ("5/6", True),
        ([0.5, 0.5], True),
        ([0.01, 0.01], False),
        ("energy-1d", False),
        ("energy-2x2", False),
    ],
    ids=str,
)
def test_report_names_factors_that_are_too_stiff_for_a_soft_core(shear: Any, warns: bool) -> None:
    codes = {finding["code"] for finding in report(hybrid(), shear=shear).findings}
    assert ("laminate-soft-core" in codes) == warns


MATERIALS = {"cfrp": CFRP, "foam": FOAM}
SPEC: dict[str, Any] = {
    "plies": [
        {"material": "cfrp", "angle_deg": 45.0, "thickness": 1e-3},
        {"material": "foam", "thickness": 3e-3},
    ]
}


def test_laminate_from_a_specification() -> None:
    found = laminate_from_dict(SPEC | {"offset": "bottom"}, MATERIALS, "s.json: laminates.a")
    assert found.laminate.offset == pytest.approx(2e-3)
    assert found.laminate.faces[0] == pytest.approx(0.0, abs=1e-18)
    assert found.materials == ("cfrp", "foam")
    assert found.shear == "energy-1d"
    top = laminate_from_dict(SPEC | {"offset": "top"}, MATERIALS, "").laminate
    assert top.faces[-1] == pytest.approx(0.0, abs=1e-18)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plies": []}, "plies = []: expected a list of plies"),
        ({"ofset": 1}, "ofset: unknown key"),
        ({"offset": "botom"}, "did you mean 'bottom'"),
        ({"shear_correction": "energy2x2"}, "did you mean 'energy-2x2'"),
        ({"shear_correction": [0.5]}, "two factors above 0"),
        ({"shear_correction": [0.5, -1.0]}, "two factors above 0"),
        ({"plies": [{"material": "cfpr", "thickness": 1.0}]}, "did you mean 'cfrp'"),
        ({"plies": [{"material": "cfrp"}]}, "plies[0].thickness = None: expected a number [m]"),
        ({"plies": [{"material": "cfrp", "thickness": 0.0}]}, "expected a number above 0"),
        ({"plies": [{"material": "cfrp", "thickness": 1.0, "angle": 3}]}, "unknown key"),
    ],
)
def test_messages_of_a_bad_specification(change: dict[str, Any], message: str) -> None:
    with pytest.raises(LaminateError) as found:
        laminate_from_dict(SPEC | change, MATERIALS, "s.json: laminates.a")
    assert str(found.value).startswith("s.json: laminates.a")
    assert message in str(found.value)


def test_a_laminate_needs_plies_of_some_thickness() -> None:
    with pytest.raises(LaminateError, match="without plies"):
        Laminate(())
    with pytest.raises(LaminateError, match=r"plies\[0\].thickness"):
        Laminate((Lamina(CFRP, 0.0, -1.0),))
    with pytest.raises(LaminateError, match="expected energy-1d, 5/6, energy-2x2"):
        shear_factors(hybrid(), "mindlin")
