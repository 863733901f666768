"""Tension in Newton's matrix only where the iteration refuses many steps, step by step the same."""

import numpy as np
import pytest
from samples.constraint_runs import new_run
from samples.crane_samples import rigid_crane

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.integrators.compiled import step_control as codes
from plymotion.solver.integrators.compiled.tension import SHARE, TAUT, WINDOW, count_refusal, judge
from plymotion.solver.mechanism.assembly import treated
from plymotion.solver.run.preparation import prepare

DRIVE = "drive = { smooth_step = { value = 1.0, duration = 1.0 } }"


def _after(clock, refused, pace):
    """Whether tension is in the matrix after a window with so many refusals and such a pace."""
    for k in range(int(WINDOW)):
        clock[codes.REFUSALS] += k < refused
        clock[codes.TIME] += pace
        judge(clock)
    return clock[codes.TENSE] > 0.0


def test_the_matrix_that_advances_faster():
    clock = np.zeros(codes.N_CLOCK)
    clock[codes.OTHER] = np.inf
    few, many = int(SHARE * WINDOW), int(SHARE * WINDOW) + 1
    assert not _after(clock, few, 1e-9)  # however slow
    assert _after(clock, many, 1.0)
    assert _after(clock, 0, 0.1)  # slow, but not by Newton's iteration
    assert _after(clock, many, 2.1)  # it refuses, and is faster than the other
    assert not _after(clock, many, 1.9)
    assert not _after(clock, many, 1.0)  # the other was not twice as fast
    assert _after(clock, many, 0.9)


def test_refusals_without_tension_do_not_count(tmp_path):
    """The least stiffness that may stop Newton's iteration is a part of s^2 times the inertia."""
    spec = rigid_crane(tmp_path, 2)
    model = prepare(spec.mechanism, spec.packages).model
    clock, M = np.zeros(codes.N_CLOCK), np.zeros((model.n_body, 6, 6))
    M[:, range(6), range(6)] = 2.0
    tension = np.zeros_like(M)
    tension[1, 4, 4] = 30.0
    count_refusal(model, clock, M, tension, 15.1 / TAUT)
    assert clock[codes.REFUSALS] == 0.0
    count_refusal(model, clock, M, tension, 14.9 / TAUT)
    assert clock[codes.REFUSALS] == 1.0


@pytest.mark.parametrize(
    ("name", "treatment"), [("radau", "projection"), ("generalized-alpha", "ggl")]
)
def test_steps_taken_again_are_the_same(name, treatment, tmp_path):
    """The choice is a part of the state of the loop: half of each stride is taken twice."""
    spec = rigid_crane(tmp_path, 6, drive=DRIVE)
    ready, kind = prepare(spec.mechanism, spec.packages), Treatment(treatment)
    model, ends = treated(ready.model, kind), []
    for again in (False, True):
        made = new_run(model, ready.y0, kind, name, 0.5, rtol=1e-3, atol=1e-4)
        nowhere = np.empty(0), np.empty((0, made.n))
        while made.status == "running":
            made.stride(*nowhere, 0, keep=True)
            count = len(made.steps_taken()) if again else 0
            if count > 1:
                made.take_back(count // 2)
        ends.append((made.counters.steps, made.y.copy()))
        assert made._workspace.clock[codes.TENSE] == 1.0
    assert ends[0][0] == ends[1][0]
    np.testing.assert_array_equal(ends[0][1], ends[1][1])
