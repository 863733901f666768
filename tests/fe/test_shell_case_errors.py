"""Load cases have estimates of their errors by the mesh where that is cheap, or with --verify."""

from typing import Any

import numpy as np
import pytest
from samples.shell_specs import EDGES, mesh_from, plate

from plymotion.preprocess.shell.analyses import discretisation
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.shell_cells import ShellMesh
from plymotion.solver.report.shell.findings import shell_json
from plymotion.solver.report.shell.shell_text import shell_text

pytestmark = pytest.mark.one_end
PRESSURE = {"p": {"all": {"pressure": 1.0}}}
CLAMPED = {name: {"at": name, "fixed": "all"} for name in EDGES}


def _rhombus(n: int, angle_deg: float) -> ShellMesh:
    angle, grid = np.radians(angle_deg), np.linspace(0.0, 1.0, n + 1)
    points = [[x + y * np.cos(angle), y * np.sin(angle), 0.0] for y in grid for x in grid]
    number = np.arange(len(points)).reshape(n + 1, n + 1)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    cells = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, d), (b, c, d))])
    rows = {"bottom": number[0], "top": number[-1], "left": number[:, 0], "right": number[:, -1]}
    return mesh_from(points, cells, **{k: np.stack([r[:-1], r[1:]], 1) for k, r in rows.items()})


def _found(n: int, angle_deg: float, supports: dict[str, Any], **asked: Any) -> Any:
    spec = plate(n, 0.01, supports=supports, loads=PRESSURE)
    return analyse(spec, mesh=_rhombus(n, angle_deg), **asked)


def _coarse(found: Any) -> list[str]:
    return [w["message"] for w in found.warnings if w["code"] == "shell-mesh-coarse"]


@pytest.mark.parametrize("angle_deg", [30.0, 60.0, 90.0])
def test_clamped_rhombi(angle_deg: float) -> None:
    right = float(_found(48, angle_deg, CLAMPED).cases.energy[0])
    for n in (4, 8, 16):
        found = _found(n, angle_deg, CLAMPED)
        error = float(found.cases.error[0])
        true = float(found.cases.energy[0]) / right - 1.0
        assert abs(error - true) < 0.25 * abs(true) + 0.002
        assert len(_coarse(found)) == (abs(error) > 0.05)
        assert shell_json(found)["cases"]["p"]["energy_error"] == error
        assert f"{100.0 * error:+.2g} % of the strain energy" in shell_text(found)


def test_a_rhombus_clamped_on_one_edge() -> None:
    """At its sharp and blunt corners the error falls with a low power of the cell size."""
    edge = {"left": CLAMPED["left"]}
    one, two, three = (float(_found(n, 30.0, edge).cases.energy[0]) for n in (20, 40, 80))
    right = three - (three - two) ** 2 / (three - 2.0 * two + one)  # of any order
    for n in (6, 8, 12):
        found = _found(n, 30.0, edge)
        error, true = float(found.cases.error[0]), float(found.cases.energy[0]) / right - 1.0
        assert true < -0.045
        assert 0.75 < error / true < 1.4
        assert len(_coarse(found)) == (abs(error) > 0.05)


def test_many_unknowns_are_estimated_on_request_only() -> None:
    """26 x 26 nodes have 4056 unknowns."""
    found = _found(25, 90.0, CLAMPED)
    assert found.cases.error is None
    case, reason = shell_json(found)["cases"]["p"], "the mesh has many unknowns; --verify does"
    assert (case["energy_error"], case["energy_error_left_out"]) == (None, reason)
    assert f"not estimated: {reason}" in shell_text(found)
    asked = _found(25, 90.0, CLAMPED, verify=True)
    assert asked.cases.error is not None
    assert shell_json(asked)["cases"]["p"]["energy_error_left_out"] is None


def test_a_finer_mesh_that_is_too_large_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(discretisation, "MOST", 100)
    found = _found(4, 90.0, CLAMPED, verify=True)
    case = shell_json(found)["cases"]["p"]
    assert case["energy_error"] is None
    assert case["energy_error_left_out"].startswith("the mesh of half the cell size is too large")


def _pushed(key: str, value: list[float]) -> list[str]:
    corner = mesh_from([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    left, tip = np.array([[0, 3]]), np.array([2])
    mesh = ShellMesh(**{**vars(corner), "curves": {"left": left}, "marks": {"tip": tip}})
    spec = plate(1, 0.01, supports={"left": CLAMPED["left"]})
    spec["loads"] = {"F": {"tip": {"at": "tip", key: value}}}
    return _coarse(analyse(spec, mesh=mesh))


def test_loads_at_points() -> None:
    """A force in the plane has no limit at a point, which the advice says; nor has a moment."""
    (message,) = _pushed("force", [1.0, 0.0, 0.0])
    assert message.endswith("give forces at points a length or an area")
    assert _pushed("moment", [0.0, 0.0, 1.0]) == []
