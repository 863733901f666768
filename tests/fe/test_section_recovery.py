"""Stresses recovered from the resultants: their integrals, their energy, and reference values."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.package.common.recovery_schema import STRESSES
from plymotion.solver.package.section.section_schema import SectionFile

FOLDER = Path(__file__).resolve().parent.parent / "reference" / "sections"
DIRECTIONS = {"top": [1, 0], "right": [0, -1], "bottom": [-1, 0], "left": [0, 1]}
LOADS = [*np.eye(6), np.array([300.0, -20.0, 10.0, 0.1, 0.2, -0.3])]


def box(angles: list[float], **mesh: Any) -> dict[str, Any]:
    """A box of six plies on all walls, centred."""
    plies = [{"material": "m", "angle_deg": a, "thickness": 0.127e-3} for a in angles]
    reference = tomllib.loads((FOLDER / "21_box_layup2_30_0.toml").read_text(encoding="utf-8"))
    constants = {k: v for k, v in reference["material"].items() if k != "name"}
    walls = {f"wall_{wall}": 0.762e-3 for wall in DIRECTIONS}
    parameters = {"width": 0.0242062, "height": 0.0136398, "elements_2": 6, "elements_3": 4}
    return {
        "name": "box",
        "convention": "contour",
        "mesh": {"script": "box", "parameters": {**parameters, **walls}, **mesh},
        "materials": {"m": {"kind": "orthotropic", **constants}},
        "regions": {
            wall: {"plies": plies, "direction": {"vector": vector}}
            for wall, vector in DIRECTIONS.items()
        },
    }


def tube(angle: float) -> dict[str, Any]:
    reference = tomllib.loads((FOLDER / "14_aniso_tube_45.toml").read_text(encoding="utf-8"))
    constants = {k: v for k, v in reference["material"].items() if k != "name"}
    values = {"outer_radius": 0.075841, "wall": 0.008682}
    return {
        "name": "tube",
        "convention": "contour",
        "mesh": {"script": "tube", "parameters": values},
        "materials": {"m": {"kind": "orthotropic", **constants}},
        "regions": {
            "wall": {
                "plies": [{"material": "m", "angle_deg": angle}],
                "direction": {"circle": [0.0, 0.0]},
            }
        },
    }


@pytest.fixture(
    scope="module",
    params=[box([0, 30, 0, 30, 0, 30]), box([15, -15, 15, -15, 15, -15], degree=3), tube(45.0)],
    ids=["box", "box of degree 3", "tube"],
)
def section(request: pytest.FixtureRequest) -> SectionFile:
    return analyse(request.param, estimate=False)


def stresses(section: SectionFile, F: Any) -> tuple[Any, Any, Any]:
    """Stress in ply axes, strain in ply axes, stress tensor in section axes, of every point."""
    recovery = section.recovery
    strain = recovery.strain_M @ F
    stress = np.einsum("pij,pj->pi", recovery.C_M[recovery.ply], strain)
    tensor = np.empty((len(stress), 3, 3))
    for column, name in enumerate(STRESSES):
        i, j = (int(digit) - 1 for digit in name)
        tensor[:, i, j] = tensor[:, j, i] = stress[:, column]
    A = recovery.A_BM
    return stress, strain, A @ tensor @ np.swapaxes(A, 1, 2)


@pytest.mark.one_end
def test_stresses_carry_the_resultants(section: SectionFile) -> None:
    """Integrals of s11, s12, s13 and of their moments are F to 1e-9."""
    x2, x3 = section.recovery.points.T
    weights = section.recovery.weights
    # in units of force times a length of the section, so that entries compare
    length = np.sqrt(np.ptp(x2) * np.ptp(x3))
    size = np.array([1, 1, 1, length, length, length])
    for F in LOADS:
        _, _, tensor = stresses(section, F * size)
        s11, s12, s13 = tensor[:, 0].T
        found = np.array(
            [
                weights @ s11,
                weights @ s12,
                weights @ s13,
                weights @ (x2 * s13 - x3 * s12),
                weights @ (x3 * s11),
                -weights @ (x2 * s11),
            ]
        )
        assert np.abs(found / size - F).max() < 1e-9 * np.abs(F).max()


def test_energy_of_the_stresses_is_that_of_the_section(section: SectionFile) -> None:
    """F' K^-1 F = integral of stress times strain, to 1e-8."""
    S = np.linalg.inv(section.K)
    size = 1.0 / np.sqrt(np.diag(S))
    for F in LOADS:
        stress, strain, _ = stresses(section, F * size)
        energy = section.recovery.weights @ np.einsum("pi,pi->p", stress, strain)
        assert energy == pytest.approx((F * size) @ S @ (F * size), rel=1e-8)


def test_ply_axes_are_right_handed_rotations(section: SectionFile) -> None:
    A = section.recovery.A_BM
    assert np.abs(A @ np.swapaxes(A, 1, 2) - np.eye(3)).max() < 1e-12
    assert np.linalg.det(A) == pytest.approx(1.0)


@pytest.mark.one_end
def test_coarse_points_see_the_same_stresses() -> None:
    """Recovery at four points of each cell instead of nine: the mean stress of a ply stays."""
    spec = box([0, 30, 0, 30, 0, 30])
    fine = analyse(spec, estimate=False)
    coarse = analyse(spec, estimate=False, recovery_degree=3)
    assert len(coarse.recovery.points) == 4 * len(coarse.mesh.ply)
    F = np.array([100.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    for ply in range(len(fine.recovery.plies)):
        means = []
        for section in (fine, coarse):
            recovery = section.recovery
            here = recovery.ply == ply
            means.append(recovery.weights[here] @ stresses(section, F)[0][here])
        assert np.abs(means[0] - means[1]).max() < 1e-9 * np.abs(means[0]).max()


@pytest.mark.provokes("degree-1-locks")
def test_published_stresses_on_the_same_mesh(
    tmp_path: Path, record: Callable[[str, Any], None]
) -> None:
    """A cantilever loaded along its corner, 20 x 20 linear elements, values at their middles."""
    reference = tomllib.loads(
        (FOLDER / "30_stress_iso_square_tipload.toml").read_text(encoding="utf-8")
    )
    n, side = 20, reference["geometry"]["b"]
    x2, x3 = np.meshgrid(*[np.linspace(0.0, side, n + 1)] * 2, indexing="ij")
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    np.savez(
        tmp_path / "square.npz",
        points=np.column_stack([x2.ravel(), x3.ravel()]),
        cells=np.column_stack([corner, corner + n + 1, corner + n + 2, corner + 1]),
        cell_type="quad",
        region=np.zeros(n * n, dtype=int),
        region_names=np.array(["square"]),
    )
    m = reference["material"]
    constants = {"E1": m["E"], "E2": m["E"], "E3": m["E"], "G12": m["G"], "G13": m["G"]}
    constants |= {"G23": m["G"], "nu12": m["nu"], "nu13": m["nu"], "nu23": m["nu"], "rho": m["rho"]}
    spec = {
        "name": "square",
        "convention": "contour",
        "mesh": {"arrays": str(tmp_path / "square.npz"), "degree": 1},
        "materials": {"m": {"kind": "orthotropic", **constants}},
        "regions": {"square": {"plies": [{"material": "m", "angle_deg": 0.0}]}},
    }
    section = analyse(spec, estimate=False, recovery_degree=1)
    assert [warning["code"] for warning in section.warnings] == ["degree-1-locks"]
    load = reference["load"]["section_resultants"]
    F = np.array([load[name] for name in ("F1", "F2", "F3", "M1", "M2", "M3")])
    stress, strain, _ = stresses(section, F)
    assert len(stress) == n * n

    def at(x: float, y: float) -> int:
        distance = np.linalg.norm(section.recovery.points - [x, y], axis=1)
        assert distance.min() < 1e-12
        return int(np.argmin(distance))

    values = reference["published"]
    found = []
    for _, x, y, component, value in values["stress"]:
        i = STRESSES.index("".join(sorted(component[1:])))
        found.append(stress[at(x, y), i])
        assert found[-1] == pytest.approx(value, rel=1e-4)
    for _, x, y, component, value in values["strain"]:
        i = STRESSES.index(component[-2:])
        assert strain[at(x, y), i] == pytest.approx(value, rel=1e-4)
    record("section/stress/tipload", found)
