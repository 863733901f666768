"""Buckling of laminated cylinders and their frequencies under load, against Ritz series.

tests/peers/cylinder_peer.py is exact for cross plies under compression and external pressure, and
converges for all others. R/h = 50, L = R, E1/E2 = 40, both ends simply supported (SS3).
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers import cylinder_peer
from samples.cylinder_samples import LAMINA, cylinder, write_cylinder

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

R = L = 1.0
H = 0.02
LOADS: dict[str, tuple[Any, float]] = {
    "compression": ((-1.0, 0.0, 0.0), 0.0),
    "pressure": ((0.0, -R, 0.0), -1.0),
    # the angle of the mesh counts from z towards y, against a moment about x
    "torsion": ((0.0, 0.0, -1.0 / (2.0 * np.pi * R**2)), 0.0),
}

# Buckling and frequencies under loads with both DOLFINx: test_shell_buckling.py.
pytestmark = pytest.mark.one_end


def stiffness(spec: dict[str, Any]) -> tuple[Any, Any]:
    """ABD (6, 6) and Ds (2, 2) of the wall."""
    found = ShellProblem(spec).regions[0].stiffness
    return found.ABD, found.Ds


def series(spec: dict[str, Any], load: str, waves: Any, terms: int = 18) -> float:
    """The smallest load factor of the peer, all half waves along together."""
    N, p = LOADS[load]
    ABD, Ds = stiffness(spec)
    return min(cylinder_peer.factor(ABD, Ds, R, L, n, range(terms), N, p) for n in waves)


def test_the_series_give_classical_loads() -> None:
    """The stress of Lorenz and Timoshenko, and the pressure of Levy on a long tube."""
    E, nu, h = 70e9, 0.3, 0.01
    A, D = E * h / (1.0 - nu**2), E * h**3 / (12.0 * (1.0 - nu**2))
    plane = np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    none = np.zeros((3, 3))
    ABD = np.block([[A * plane, none], [none, D * plane]])
    Ds = 5.0 / 6.0 * E / (2.0 * (1.0 + nu)) * h * np.eye(2)
    classical = E * h**2 / (R * np.sqrt(3.0 * (1.0 - nu**2)))
    found = cylinder_peer.smallest(ABD, Ds, R, 0.8, range(1, 20), range(1, 9), (-1.0, 0.0, 0.0))
    assert found[0] / classical == pytest.approx(0.99, abs=0.01)
    long = cylinder_peer.smallest(ABD, Ds, R, 200.0, range(2, 4), [1], *LOADS["pressure"])
    assert long[0] == pytest.approx(3.0 * D / R**3, rel=3e-4)


SYMMETRIC = [[0.0, 90.0, 90.0, 0.0], [90.0, 0.0, 0.0, 90.0]]
CROSS_PLIES = [
    *((angles, "quadrilaterals") for angles in ([0.0, 90.0], [90.0, 0.0], *SYMMETRIC)),
    *((angles, "triangles") for angles in SYMMETRIC),
]


EXACT: dict[tuple[Any, str], tuple[float, int, int]] = {}


def exact(spec: dict[str, Any], angles: list[float], load: str) -> tuple[float, int, int]:
    """The smallest factor of the peer with an even n, its n and m; computed once for each wall."""
    key = tuple(angles), load
    if key not in EXACT:
        waves, along = range(2, 26, 2), range(1, 9)
        EXACT[key] = cylinder_peer.smallest(*stiffness(spec), R, L, waves, along, *LOADS[load])
    return EXACT[key]


@pytest.mark.provokes("laminate-unsymmetric")
@pytest.mark.parametrize("load", ["compression", "pressure"])
@pytest.mark.parametrize(("angles", "element"), CROSS_PLIES)
def test_cross_plies(angles: list[float], load: str, element: str, tmp_path: Path) -> None:
    """A quarter of the cylinder, modes with an even number of waves around."""
    n = (24, 36) if element == "quadrilaterals" else (40, 60)
    file = write_cylinder(tmp_path / "c.msh", R, L, n, 90.0, triangles=element == "triangles")
    spec = cylinder(file, angles, H, load)
    result = analyse(spec)
    found = result.buckling
    assert found is not None
    codes = [warning["code"] for warning in result.warnings]
    assert codes == ([] if angles in SYMMETRIC else ["laminate-unsymmetric"])
    bound = 0.015 if element == "quadrilaterals" else 0.025
    assert 0.0 < found.factors[0] / exact(spec, angles, load)[0] - 1.0 < bound


@pytest.mark.provokes("laminate-unsymmetric", "shell-mesh-coarse")
@pytest.mark.parametrize("load", ["compression", "pressure"])
@pytest.mark.parametrize("element", ["quadrilaterals", "triangles"])
def test_estimated_errors(load: str, element: str, tmp_path: Path) -> None:
    """The finer mesh lies on the cylinder, so that the error of flat cells is in the estimate."""
    n = (12, 18) if element == "quadrilaterals" else (16, 24)
    file = write_cylinder(tmp_path / "c.msh", R, L, n, 90.0, triangles=element == "triangles")
    spec = cylinder(file, [0.0, 90.0], H, load)
    spec["buckling"]["error"] = True
    result = analyse(spec)
    found = result.buckling
    assert found is not None
    assert found.error is not None
    codes = {warning["code"] for warning in result.warnings} - {"laminate-unsymmetric"}
    assert codes == ({"shell-mesh-coarse"} if found.error[0] > 0.05 else set())
    error = found.factors[0] / exact(spec, [0.0, 90.0], load)[0] - 1.0
    assert error > 0.03
    assert found.error[0] == pytest.approx(error, rel=0.15)


@pytest.mark.provokes("laminate-unsymmetric")
@pytest.mark.parametrize("angles", [[0.0, 90.0], [90.0, 0.0, 0.0, 90.0]])
def test_curved_panels(angles: list[float], tmp_path: Path) -> None:
    """A panel of 90 deg under axial compression, simply supported at all edges.

    Waves that vanish at the straight edges are those of the whole cylinder with n = 2, 4, ...
    """
    file = write_cylinder(tmp_path / "c.msh", R, L, (16, 24), 90.0)
    spec = cylinder(file, angles, H, "compression")
    for name in ("first", "second"):
        spec["supports"][name]["only"] = "loads"
    # w, u and the rotation about x at the straight edges; tangents are y and z there
    spec["supports"]["one"] = {"at": "first", "fixed": ["ux", "uz", "ry"], "only": "modes"}
    spec["supports"]["other"] = {"at": "second", "fixed": ["ux", "uy", "rz"], "only": "modes"}
    del spec["supports"]["axial"]
    spec["buckling"]["error"] = True
    result = analyse(spec)
    found = result.buckling
    assert found is not None
    assert found.error is not None
    codes = {warning["code"] for warning in result.warnings}
    assert codes <= {"laminate-unsymmetric"}
    expected, n, _ = exact(spec, angles, "compression")
    assert n > 2
    assert expected < found.factors[0] < 1.04 * expected
    assert found.factors[0] / (1.0 + found.error[0]) == pytest.approx(expected, rel=5e-3)


def test_torsion_depends_on_its_sense(tmp_path: Path) -> None:
    """A whole cylinder: modes are spirals, every factor is there twice."""
    file = write_cylinder(tmp_path / "c.msh", R, L, (24, 96))
    ratios = []
    for angles, waves in (
        ([0.0, 90.0, 90.0, 0.0], (6, 7, 8)),
        ([45.0, -45.0, -45.0, 45.0], (6, 7, 8)),
    ):
        spec = cylinder(file, angles, H, "torsion", sector=False)
        found = analyse(spec).buckling
        assert found is not None
        assert found.factors[1] == pytest.approx(found.factors[0], rel=1e-6)
        ratios.append(found.factors[0] / series(spec, "torsion", waves))
        if angles[0] == 45.0:
            assert -found.reversed[0] < 0.45 * found.factors[0]
    assert ratios == pytest.approx([1.0, 1.0], abs=0.035)
    assert min(ratios) > 1.0


def test_off_axis_plies_under_compression(tmp_path: Path) -> None:
    file = write_cylinder(tmp_path / "c.msh", R, L, (24, 96))
    spec = cylinder(file, [30.0, -30.0, -30.0, 30.0], H, "compression", sector=False)
    found = analyse(spec).buckling
    assert found is not None
    assert found.factors[0] / series(spec, "compression", (2, 3)) == pytest.approx(1.0, abs=0.02)


@pytest.mark.provokes("laminate-unsymmetric")
def test_cylinder_of_geier_and_singh(tmp_path: Path) -> None:
    """Z11 of Table 3 in Aerospace Science and Technology 1 (1997) 47: ten plies, R/h = 200."""
    angles = [60.0, -60.0, 0.0, 0.0, 68.0, -68.0, 52.0, -52.0, 37.0, -37.0]
    radius, length = 0.25, 0.51
    file = write_cylinder(tmp_path / "c.msh", radius, length, (24, 90))
    spec = cylinder(file, angles, 1.25e-3, "compression", sector=False)
    spec["laminates"]["wall"]["shear_correction"] = "energy-1d"
    constants = {"E1": 123.55e9, "E2": 8.7079e9, "E3": 8.7079e9, "G12": 5.695e9, "G13": 5.695e9}
    constants |= {"G23": 3.4e9, "nu12": 0.319, "nu13": 0.319, "nu23": 0.4, "rho": 1600.0}
    spec["materials"]["ply"] = {**LAMINA, **constants}
    result = analyse(spec)
    found = result.buckling
    assert found is not None
    assert [warning["code"] for warning in result.warnings] == ["laminate-unsymmetric"]
    ABD, Ds = stiffness(spec)
    N = LOADS["compression"][0]
    around = 2.0 * np.pi * radius
    expected = around * cylinder_peer.factor(ABD, Ds, radius, length, 6, range(20), N)
    assert expected == pytest.approx(274.1e3, rel=3e-3)
    assert around * found.factors[0] == pytest.approx(expected, rel=0.03)


def test_frequencies_under_load(tmp_path: Path) -> None:
    """A cross-ply cylinder at rest and at half its critical load; half of its length."""
    file = write_cylinder(tmp_path / "c.msh", R, 0.5 * L, (12, 36), 90.0)
    spec = cylinder(file, [0.0, 90.0, 90.0, 0.0], H, "compression")
    spec["supports"]["near"] = {"at": "near", "fixed": "symmetry-x"}
    del spec["supports"]["axial"], spec["supports"]["still"]
    ABD, Ds = stiffness(spec)
    mass = LAMINA["rho"] * H, LAMINA["rho"] * H**3 / 12.0
    critical = cylinder_peer.smallest(ABD, Ds, R, L, range(2, 20, 2), (1, 3, 5), (-1.0, 0.0, 0.0))
    force = -0.5 * critical[0]
    spec["loads"]["compression"]["far"]["force_per_length"] = [force, 0.0, 0.0]
    found = []
    for prestress, N in ((None, 0.0), ("compression", force)):
        spec["frequencies"] = {"count": 1, "error": True}
        if prestress is not None:
            spec["frequencies"]["prestress"] = prestress
        modes = analyse(spec).modes
        assert modes is not None
        found.append(modes.frequencies[0])
        expected = min(
            cylinder_peer.frequency(ABD, Ds, R, L, n, m, (N, 0.0, 0.0), mass)
            for n in range(2, 16, 2)
            for m in (1, 3)
        )
        assert found[-1] == pytest.approx(expected, rel=0.01)
        assert modes.error is not None
        assert found[-1] / (1.0 + modes.error[0]) == pytest.approx(expected, rel=2e-3)
    assert found[1] < 0.8 * found[0]
