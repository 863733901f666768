"""Rigid loops with hinges that are not quite parallel are refused, singular starts are not."""

from itertools import pairwise

import numpy as np
import pytest
from samples.case_samples import case_runs
from samples.mechanism_samples import GROUND, Rods

from plymotion.solver.errors import InputError
from plymotion.solver.mechanism.consistent import consistent_state, redundancy
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.preparation import prepare

DRIVE = {"ramp": {"speed": -0.6, "duration": 1.0}}


def _axis(tilt: float) -> list[float]:
    return [float(np.sin(tilt)), 0.0, float(np.cos(tilt))]


@pytest.fixture(scope="module")
def four_bar(repository, tmp_path_factory):
    """The four-bar of the case with rigid bars, and a torque on its crank."""
    runs = case_runs(repository, "misaligned-four-bar", tmp_path_factory.mktemp("build"))
    return read_run(runs / "rigid.json")


@pytest.mark.parametrize("tilt", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("drive", [None, DRIVE], ids=["pushed", "driven"])
def test_a_loop_that_is_locked_by_little_is_refused(four_bar, tilt, drive):
    """A torque on it took 62,965 steps at 1e-2, and a stall below, with velocities that joints
    exclude; a drive failed after 0.01 to 0.1 s.
    """
    spec = four_bar.changed({"joints.C.axis": _axis(tilt), "joints.A.drive": drive})
    with pytest.raises(
        InputError, match=r"locked by a small misalignment: a motion of 0\.1 rad"
    ) as e:
        prepare(spec.mechanism, spec.packages)
    told = str(e.value)
    assert all(f"{name}: " in told for name in "ABCD")
    # the gap in words is that of the tilt, at a tenth of a radian
    at_c = float(told.split("C: ")[1].split(" m apart, ")[1].split(" rad")[0])
    assert 0.02 * tilt < at_c < 0.1 * tilt


def test_a_loop_that_is_clearly_locked_stands_still(four_bar):
    """At 5 degrees, as shipped, the torque finds its reaction; a drive is refused."""
    result, summary = execute(four_bar, progress=False)
    assert summary["completed"]
    assert summary["cost"]["steps"] < 50
    angle = next(s.values for s in result.signals if s.name == "crank_angle")
    assert np.abs(angle).max() < 1e-9
    driven = four_bar.changed({"joints.A.drive": DRIVE})
    with pytest.raises(InputError, match=r"locked: .* nothing can follow A \(drive\)"):
        prepare(driven.mechanism, driven.packages)


def _loop(points, tilt: float = 0.0, carriage: bool = False) -> Rods:
    """Hinges at points, the last rod back to the first; on a sliding carriage or the ground."""
    rods = Rods(side=0.1)
    base = GROUND
    if carriage:
        base = rods.rod(points[0], points[-1])
        rods.joint("slide", "prismatic", GROUND, base, points[0], (1.0, 0.0, 0.0))
    links = [base, *(rods.rod(a, b) for a, b in pairwise(points)), base]
    for i, point in enumerate(points):
        rods.joint(f"{i}", "revolute", links[i], links[i + 1], point, _axis(tilt * (i == 2)))
    return rods


def _found(rods: Rods):
    sample = rods.sample((0, (0.0, 0.0, 0.0)))
    y = consistent_state(sample.model, sample.start, sample.names)
    return redundancy(sample.model, y, sample.names)


SQUARE = [(0.0, 0.0, 0.0), (0.2, 1.0, 0.0), (1.3, 1.1, 0.0), (1.0, 0.0, 0.0)]


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_also_where_the_rest_of_the_mechanism_moves(size):
    points = [tuple(size * np.array(p)) for p in SQUARE]
    assert _found(_loop(points, carriage=True)).count == 3
    with pytest.raises(InputError, match="small misalignment"):
        _found(_loop(points, 1e-4, carriage=True))


@pytest.mark.parametrize("away", [1e-1, 1e-2, 1e-3, 1e-4, 1e-6])
def test_a_start_near_a_singular_position_is_no_lock(away):
    """A parallelogram folded up to an angle: its second branch is near, its motion is free."""
    up = (np.sin(away), np.cos(away))
    points = [(0.0, 0.0, 0.0), (up[1], up[0], 0.0), (2 + up[1], up[0], 0.0), (2.0, 0.0, 0.0)]
    assert _found(_loop(points)).count == 3
