"""One evaluation of the equations of motion: body by body and dense, and nothing left behind."""

import numpy as np
import pytest
from samples.constraint_runs import prepared
from samples.flexible_samples import random_mechanism, random_state
from samples.mechanism_samples import bricard, chain, four_bars

from plymotion.solver.dynamics.analysis.projection import _dense_project, projected
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import (
    accelerations,
    assemble,
    by_blocks,
    dense_derivative_into,
    derivative,
    derivative_into,
)
from plymotion.solver.dynamics.model.coordinates import moved
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.integrators.step_loop import right_hand_side
from plymotion.solver.mechanism.assembly import assemble_model, treated
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, rigid_body

# Closed loops with surplus rows, of bodies with inertia about every axis.
LOOPS = {
    "four-bar": lambda: four_bars(1, core=1e-2),
    "four loops": lambda: four_bars(4, core=1e-2),
    "bricard": bricard,
    "chain": lambda: chain(6),
}
PLAIN = Treatment("index1")


def _both(model, t, y):
    """Derivative and multipliers, body by body and by dense linear algebra."""
    assert by_blocks(model)
    work, out, expected = new_workspace(model), np.empty(y.size), np.empty(y.size)
    derivative_into(model, work, t, y, out)
    multipliers = work.multipliers.copy()
    dense_derivative_into(model, work, t, y, expected)
    return (out, multipliers), (expected, accelerations(model, assemble(model, t, y), y)[1])


def _close(found, expected, tolerance):
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance * max(1.0, np.abs(b).max()))


@pytest.mark.parametrize("loops", [0, 2])
@pytest.mark.parametrize("name", ["index1", "baumgarte", "projection"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_flexible_trees_and_loops(seed, name, loops):
    """Random states, nowhere near the constraints: the algebra does not ask for them."""
    model = treated(random_mechanism(seed, loops), Treatment(name))
    y = random_state(np.random.default_rng(seed), model)
    _close(*_both(model, 0.3, y), 1e-9)


@pytest.mark.parametrize("sample", LOOPS)
@pytest.mark.parametrize("name", ["augmented-lagrangian", "projection"])
def test_surplus_rows_share_their_forces_at_least_norm(sample, name):
    """By the penalty where it is needed; a moving mechanism, so that gamma does not vanish."""
    model, y = prepared(LOOPS[sample](), Treatment(name))
    rng = np.random.default_rng(7)
    Phi_q = assemble(model, 0.0, y).Phi_q
    null = np.linalg.svd(Phi_q)[2][np.linalg.matrix_rank(Phi_q, tol=1e-9) :]
    y[model.n_pos : -1] = rng.normal(size=len(null)) @ null
    found, expected = _both(model, 0.0, y)
    _close(found, expected, 1e-8)


def test_index1_and_surplus_rows_take_dense_linear_algebra():
    model, y = prepared(four_bars(1, core=1e-2), PLAIN)
    assert not by_blocks(model)
    expected = accelerations(model, assemble(model, 0.0, y), y)[0]
    np.testing.assert_array_equal(derivative(model, 0.0, y)[model.n_pos : -1], expected)


def test_massless_bodies():
    """A rod's end fixed to a body without inertia, on which the hinge stands: a pendulum still."""
    length, inertia = 2.0, np.diag([0.1, 0.4, 0.4])
    rod = rigid_body("rod", 1.5, np.array([0.5 * length, 0.0, 0.0]), inertia)
    massless = rigid_body("massless", 0.0, np.zeros(3), np.zeros((3, 3)))
    markers = [MarkerTable(k, np.zeros(3)) for k in (-1, 1, 1, 0)]
    joints = [JointTable("hinge", "revolute", 0, 1), JointTable("tie", "fixed", 2, 3)]
    model = assemble_model([rod, massless], markers, joints, gravity_G=(0.0, -9.81, 0.0))
    assert by_blocks(model)
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[[3, 10]] = 1.0
    rate = derivative(model, 0.0, y)[model.n_pos : -1]
    torque, about = -1.5 * 9.81 * 0.5 * length, 0.4 + 1.5 * (0.5 * length) ** 2
    np.testing.assert_allclose(rate.reshape(2, 6)[:, 5], torque / about, rtol=1e-12)
    alone = assemble_model([rod], [markers[0], markers[3]], [JointTable("hinge", "revolute", 0, 1)])
    assert by_blocks(alone)


@pytest.mark.parametrize("name", ["tree", "penalty"])
def test_an_evaluation_leaves_no_trace_in_the_next(name):
    """The same numbers bit for bit, for any state evaluated in between."""
    if name == "tree":
        model = random_mechanism(5, 2)
        states = [random_state(np.random.default_rng(k), model) for k in (1, 2)]
    else:
        model, one = prepared(four_bars(2, core=1e-2), Treatment("projection"))
        states = [one, one.copy()]
        states[1][: model.n_pos] = moved(model, one[: model.n_pos], np.full(model.n_vel, 0.1))
    work, out = new_workspace(model), np.empty(states[0].size)
    found = []
    for t, y in ((0.1, states[0]), (0.7, states[1]), (0.1, states[0])):
        before = y.copy()
        out[:] = np.nan
        derivative_into(model, work, t, y, out)
        np.testing.assert_array_equal(y, before)
        found.append((out.copy(), work.multipliers.copy()))
    fresh = derivative(model, 0.1, states[0])
    for a, b in zip(found[0], found[2], strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(found[0][0], fresh)
    assert np.abs(found[1][0] - found[0][0]).max() > 1e-3


def test_projection_leaves_no_trace_in_the_next_evaluation():
    model, y = prepared(chain(3), Treatment("projection"))
    work, out = new_workspace(model), np.empty(y.size)
    off = y + 1e-3 * np.random.default_rng(1).normal(size=y.size)
    expected = derivative(model, 0.0, y)
    off, _ = projected(model, 0.0, off, work)
    derivative_into(model, work, 0.0, y, out)
    np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("sample", LOOPS)
def test_projection_is_that_of_dense_linear_algebra(sample):
    """From as far off as a rough step comes: by 1e-5 m and rad.

    Much farther off, surplus rows are no longer surplus, and contradict the others.
    """
    model, y = prepared(LOOPS[sample](), Treatment("projection"))
    rng = np.random.default_rng(3)
    off = y.copy()
    off[: model.n_pos] = moved(model, y[: model.n_pos], 1e-5 * rng.normal(size=model.n_vel))
    off[model.n_pos : -1] += 1e-4 * rng.normal(size=model.n_vel)
    found, reached = projected(model, 0.0, off)
    assert reached
    equations = assemble(model, 0.0, found)
    assert np.abs(equations.Phi).max() < 1e-9
    assert np.abs(equations.Phi_q @ found[model.n_pos : -1] + equations.Phi_t).max() < 1e-9
    expected = off.copy()
    memory = np.empty(model.n_vel), np.empty(model.n_pos)
    reached = _dense_project(model, new_workspace(model), 0.0, expected, *memory)
    assert reached
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9)


def test_rates_come_in_one_array_and_the_state_is_not_kept():
    """What the contract of the integrators allows and forbids."""
    model = random_mechanism(6, 1)
    y = random_state(np.random.default_rng(6), model)
    f = right_hand_side(model)
    first = f(0.0, y).copy()
    f(0.5, 1.1 * y)
    np.testing.assert_array_equal(f(0.0, y), first)
