"""Materials: constants, bounds, rotation."""

from typing import Any

import numpy as np
import pytest

from plymotion.solver.package.common.materials import (
    MaterialError,
    Orthotropic,
    bond,
    isotropic,
    material_from_dict,
    ply_rotation,
    rotated,
)

GRAPHITE = {
    "kind": "orthotropic",
    "E1": 142e9,
    "E2": 9.8e9,
    "E3": 9.0e9,
    "G12": 6.0e9,
    "G13": 5.5e9,
    "G23": 4.8e9,
    "nu12": 0.30,
    "nu13": 0.32,
    "nu23": 0.42,
    "rho": 1600.0,
}


def graphite() -> Orthotropic:
    return material_from_dict(GRAPHITE, "case.toml: materials.graphite")


def some_rotation(seed: int) -> Any:
    Q, R = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.linalg.det(Q)


def tensor(column: Any, shear: float) -> Any:
    """Symmetric tensor of a column 11, 22, 33, 23, 13, 12; `shear` 1/2 for engineering strains."""
    a, b, c, d, e, f = column
    d, e, f = shear * d, shear * e, shear * f
    return np.array([[a, f, e], [f, b, d], [e, d, c]])


def column(T: Any, shear: float) -> Any:
    return np.array([T[0, 0], T[1, 1], T[2, 2], T[1, 2] / shear, T[0, 2] / shear, T[0, 1] / shear])


def test_isotropic_is_hooke() -> None:
    """Stress = lambda trace(eps) 1 + 2 mu eps; the shear modulus decides the factor of (17)."""
    E, nu = 73e9, 0.33
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    strain = np.array([1.0, -2.0, 3.0, 0.5, -0.25, 0.75]) * 1e-3
    eps = tensor(strain, 0.5)
    expected = column(lam * np.trace(eps) * np.eye(3) + 2 * mu * eps, 1.0)
    C = isotropic(E, nu, 2700.0).stiffness_M
    assert C @ strain == pytest.approx(expected, rel=1e-12)
    assert C[5, 5] == pytest.approx(mu)


def test_uniaxial_tension_gives_the_constants_back() -> None:
    m = graphite()
    strain = np.linalg.solve(m.stiffness_M, [1e6, 0, 0, 0, 0, 0])
    assert 1e6 / strain[0] == pytest.approx(m.E1)
    assert -strain[1] / strain[0] == pytest.approx(m.nu12)
    assert -strain[2] / strain[0] == pytest.approx(m.nu13)
    strain = np.linalg.solve(m.stiffness_M, [0, 1e6, 0, 0, 0, 0])
    assert -strain[2] / strain[1] == pytest.approx(m.nu23)


def test_order_of_shear_is_23_13_12() -> None:
    m = graphite()
    assert np.diag(m.stiffness_M)[3:] == pytest.approx([m.G23, m.G13, m.G12])


@pytest.mark.parametrize("seed", range(4))
def test_rotation_is_that_of_tensors(seed: int) -> None:
    """Stress in member axes by the rotated stiffness = rotated stress of the rotated strain."""
    A_BM, C_M = some_rotation(seed), graphite().stiffness_M
    strain_B = np.random.default_rng(seed + 10).standard_normal(6)
    strain_M = column(A_BM.T @ tensor(strain_B, 0.5) @ A_BM, 0.5)
    stress_B = column(A_BM @ tensor(C_M @ strain_M, 1.0) @ A_BM.T, 1.0)
    assert rotated(C_M, A_BM) @ strain_B == pytest.approx(stress_B, rel=1e-9)


def test_rotations_compose() -> None:
    A, B = some_rotation(1), some_rotation(2)
    assert bond(A @ B) == pytest.approx(bond(A) @ bond(B), abs=1e-12)


def test_ply_angle_turns_the_fibre_towards_2() -> None:
    fibre = ply_rotation(30.0) @ [1.0, 0.0, 0.0]
    assert fibre == pytest.approx([np.sqrt(3) / 2, 0.5, 0.0])
    C = rotated(graphite().stiffness_M, ply_rotation(30.0))
    assert C[0, 5] > 0  # tension along 1 of a fibre at +30 deg needs positive shear stress
    assert C[3, 4] != 0
    zero = C[np.ix_([0, 1, 2, 5], [3, 4])]
    assert np.abs(zero).max() < 1e-6  # the zeros of (18), in Pa


def test_quarter_turn_swaps_the_axes() -> None:
    m = graphite()
    C = rotated(m.stiffness_M, ply_rotation(90.0))
    order = [1, 0, 2, 4, 3, 5]
    assert pytest.approx(m.stiffness_M[np.ix_(order, order)], rel=1e-12, abs=1e-3) == C


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"nu12": 1e308}, r"graphite\.nu12 = 1e\+308: expected nu12"),
        ({"nu12": 4.0}, r"graphite\.nu12 = 4: expected nu12\^2 < E1/E2 = 14\.4898"),
        ({"nu23": -1.2}, r"nu23 = -1.2: expected nu23\^2 < E2/E3"),
        ({"nu12": 3.0, "nu13": 3.0, "nu23": 0.9}, r"together are too large"),
        ({"E2": -1.0}, r"E2 = -1 Pa: expected a value above 0"),
        ({"rho": 0.0}, r"rho = 0 kg/m3: expected a value above 0"),
        ({"G12": "stiff"}, r"G12 = 'stiff': expected a number \[Pa\]"),
        ({"G12": float("nan")}, r"G12 = nan: expected a number"),
        ({"G12": True}, r"G12 = True: expected a number"),
        ({"nu21": 0.1}, r"nu21: unknown key of an orthotropic material.*did you mean"),
        ({"kind": {}}, r"kind = {}: expected one of isotropic"),
        ({"kind": "orthotrop"}, r"kind = 'orthotrop'.*did you mean 'orthotropic'"),
    ],
)
def test_impossible_constants(change: dict[str, Any], message: str) -> None:
    with pytest.raises(MaterialError, match=message) as error:
        material_from_dict({**GRAPHITE, **change}, "case.toml: materials.graphite")
    assert str(error.value).startswith("case.toml: materials.graphite")


def test_missing_constant() -> None:
    table = {key: value for key, value in GRAPHITE.items() if key != "G23"}
    with pytest.raises(MaterialError, match=r"graphite\.G23: missing"):
        material_from_dict(table, "graphite")


@pytest.mark.parametrize("nu", [0.5, 0.7, -1.0])
def test_isotropic_bounds(nu: float) -> None:
    table = {"kind": "isotropic", "E": 1e9, "nu": nu, "rho": 1.0}
    with pytest.raises(MaterialError, match=r"alu\.nu = .*expected -1 < nu < 0\.5"):
        material_from_dict(table, "alu")


@pytest.mark.parametrize("ulps", [-8, -4, -1, 0, 1, 4])
def test_constants_at_the_bound_are_refused_whatever_the_rounding(ulps: int) -> None:
    nu12 = float(np.sqrt(142 / 9.8)) * (1.0 + ulps * np.finfo(float).eps)
    with pytest.raises(MaterialError):
        material_from_dict({**GRAPHITE, "nu13": 0.0, "nu23": 0.0, "nu12": nu12}, "m")


@pytest.mark.parametrize("factor", [0.999999, 1.000001])
def test_bound_is_where_definiteness_ends(factor: float) -> None:
    """The bound in the message is exact: just below it, the compliance is definite."""
    base = {"nu13": 0.0, "nu23": 0.0, "nu12": factor * np.sqrt(142 / 9.8)}
    if factor < 1:
        m = material_from_dict({**GRAPHITE, **base}, "m")
        assert np.linalg.eigvalsh(m.compliance_M)[0] > 0
    else:
        with pytest.raises(MaterialError):
            material_from_dict({**GRAPHITE, **base}, "m")
