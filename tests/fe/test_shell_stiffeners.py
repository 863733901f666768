"""Beams that stiffen a shell by sharing its nodes, against beams of the whole section."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from samples.section_specs import rectangle_spec
from samples.shell_specs import METAL, plate

from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError

Record = Callable[[str, Any], None]
LENGTH, WIDTH, H = 1.0, 0.05, 0.002
SIDE, ARM = 0.004, 0.006  # of a square stiffener, and of its centre above the plate
MATERIAL = {**METAL, "nu": 0.0}


def _square(side: float) -> dict[str, Any]:
    """Stiffness and mass of a square section of the material, shear included."""
    E, rho, A, inertia = MATERIAL["E"], MATERIAL["rho"], side**2, side**4 / 12
    G = E / 2
    twist = 0.1405770 * side**4
    stiffness = np.diag([E * A, 5 / 6 * G * A, 5 / 6 * G * A, G * twist, E * inertia, E * inertia])
    mass = np.diag([rho * A] * 3 + [2 * rho * inertia, rho * inertia, rho * inertia])
    return {"stiffness": stiffness.tolist(), "mass": mass.tolist()}


def _strip(offset: float, **tables: Any) -> dict[str, Any]:
    both = {
        name: {"at": name, "offset": [0.0, offset], **_square(SIDE)} for name in ("bottom", "top")
    }
    return plate(
        (40, 4),
        H,
        LENGTH,
        WIDTH,
        materials={"metal": MATERIAL},
        stiffeners=both,
        supports={"root": {"at": "left", "fixed": "all"}},
        links={"end": {"at": "right", "kind": "rigid"}},
        **tables,
    )


def _whole(offset: float) -> tuple[float, float, float]:
    """EI, mass per length and height of the axis over the plate, of strip and stiffeners."""
    E, rho = MATERIAL["E"], MATERIAL["rho"]
    A_plate, A_rib = WIDTH * H, 2 * SIDE**2
    centre = A_rib * offset / (A_plate + A_rib)
    inertia = (
        WIDTH * H**3 / 12 + A_plate * centre**2 + 2 * SIDE**4 / 12 + A_rib * (offset - centre) ** 2
    )
    return E * inertia, rho * (A_plate + A_rib), centre


@pytest.mark.parametrize("offset", [0.0, ARM])
def test_strip_with_two_ribs_is_a_beam_of_the_whole_section(offset: float, record: Record) -> None:
    EI, mass, centre = _whole(offset)
    loads = {
        "bend": {"tip": {"at": "end", "moment": [0.0, 1.0, 0.0]}},
        "push": {"tip": {"at": "end", "force": [0.0, 0.0, 1.0]}},
        "weight": {"all": {"gravity": [0.0, 0.0, -9.81]}},
    }
    probes = {"end": {"at": "end", "what": ["ux", "uz", "ry"]}}
    found = analyse(_strip(offset, loads=loads, probes=probes, frequencies={"count": 2}))
    rows = found.probes.values
    record(f"shell stiffeners {offset}", rows[:, 1] / rows[0, 1])
    ux, uz, ry = rows[0, :3]
    # a moment about y: rotation M L / EI, stretch of the plate below the common axis
    assert ry == pytest.approx(LENGTH / EI, rel=2e-3)
    assert uz == pytest.approx(-(LENGTH**2) / (2 * EI), rel=2e-3)
    if offset:
        assert ux == pytest.approx(-centre * LENGTH / EI, rel=2e-3)
    assert rows[1, 1] == pytest.approx(LENGTH**3 / (3 * EI), rel=5e-3)
    assert found.cases.loads_G[2, 2] == pytest.approx(-9.81 * mass * LENGTH, rel=1e-9)
    assert rows[2, 1] == pytest.approx(-9.81 * mass * LENGTH**4 / (8 * EI), rel=5e-3)
    f = 1.8751041**2 / (2 * np.pi * LENGTH**2) * np.sqrt(EI / mass)
    assert found.modes is not None
    assert found.modes.frequencies[0] / (2 * np.pi) == pytest.approx(f, rel=5e-3)


def test_free_stiffened_plate_has_six_rigid_motions() -> None:
    spec = _strip(ARM)
    del spec["supports"], spec["links"]
    problem = ShellProblem(spec)
    rigid = problem.freedom.rigid_motions()
    assert np.abs(problem.K @ rigid).max() < 1e-9 * np.abs(problem.K).max()
    _, mass, centre = _whole(ARM)
    inertia = rigid.T @ (problem.M @ rigid)
    assert inertia[0, 0] == pytest.approx(mass * LENGTH, rel=1e-12)
    assert inertia[0, 4] == pytest.approx(mass * LENGTH * centre, rel=1e-9)  # v_x = w_y z


def test_a_described_section_is_analysed() -> None:
    spec = _strip(0.0)
    square = rectangle_spec(SIDE, SIDE, MATERIAL)
    spec["stiffeners"]["top"] = {"at": "top", "section": square, "x2_axis": [0.0, -1.0, 0.5]}
    given, described = ShellProblem(spec).stiffeners
    scale = np.sqrt(np.diag(given.K))
    np.testing.assert_allclose(described.K / np.outer(scale, scale), np.eye(6), atol=1e-2)
    np.testing.assert_allclose(np.diag(described.M), np.diag(given.M), rtol=1e-9)
    np.testing.assert_allclose(given.A_GE[:, :, 2], [[0, 0, 1]] * 40, atol=1e-12)  # the normal
    x2 = np.array([0.0, -1.0, 0.5]) / np.sqrt(1.25)
    np.testing.assert_allclose(described.A_GE[:, :, 1], [x2] * 40, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"at": "middle"}, "stiffeners.top.at = 'middle': expected a physical curve"),
        ({"x2_axis": [1.0, 0.0, 0.0]}, "expected a direction across the curve"),
        ({"offset": [0.1]}, "expected two lengths"),
        ({"mass": None}, "expected `section`, or `stiffness` with `mass`"),
        ({"stiffness": (-np.eye(6)).tolist()}, "expected a positive definite matrix"),
        ({"sectoin": {}}, "unknown key"),
    ],
)
def test_bad_stiffeners_are_named(change: dict[str, Any], words: str) -> None:
    spec = _strip(0.0)
    entry = {**spec["stiffeners"]["top"], **change}
    spec["stiffeners"]["top"] = {k: v for k, v in entry.items() if v is not None}
    with pytest.raises(ShellError, match=words):
        ShellProblem(spec)


@pytest.mark.parametrize("seed", range(6))
def test_stiffener_without_stiffness_in_one_direction(seed: int) -> None:
    """A matrix of rank 5: the sign of its smallest eigenvalue is rounding."""
    spec = _strip(0.0)
    A = np.random.default_rng(seed).normal(size=(6, 5))
    size = np.sqrt(np.diag(spec["stiffeners"]["top"]["stiffness"]))
    spec["stiffeners"]["top"]["stiffness"] = (size[:, None] * (A @ A.T) * size).tolist()
    with pytest.raises(ShellError, match="stiffness: expected a positive definite matrix"):
        ShellProblem(spec)


def test_direction_across_the_curve_may_have_any_length() -> None:
    spec = _strip(0.0)
    spec["stiffeners"]["top"]["x2_axis"] = [0.0, -1e-9, 0.0]
    top = ShellProblem(spec).stiffeners[1]
    np.testing.assert_allclose(top.A_GE[:, :, 1], [[0.0, -1.0, 0.0]] * 40, atol=1e-12)
    spec["stiffeners"]["top"]["x2_axis"] = [1e9, 1.0, 0.0]
    with pytest.raises(ShellError, match="expected a direction across the curve"):
        ShellProblem(spec)
