"""Models of one structure stacked along a leading axis."""

import numpy as np
import pytest
from sweep_samples import FORCE, MASS, ball_plan

from plymotion.solver.dynamics.model import Model
from plymotion.solver.dynamics.order import Order
from plymotion.solver.dynamics.plan import Plan
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic import Solution, integrate
from plymotion.solver.run.ensemble import integrate_members, member, stack_models, structure
from plymotion.solver.run.preparation import prepare

FIELDS = (
    tuple(name for name in Model._fields if name != "plan") + Plan._fields[:-2] + 2 * Order._fields
)


def leaves(model):
    """The numbers and arrays of a model, in the order of FIELDS."""
    plan = model.plan
    own = (value for value in model if value is not plan)
    return (*own, *plan[:-2], *plan.mass, *plan.newton)


@pytest.fixture
def models(tmp_path):
    plan = ball_plan(tmp_path, f"{MASS} = [1, 2, 3]\n{FORCE} = [5, 6]")
    return [prepare(plan.mechanism_of(k), {}).model for k in range(len(plan.members))]


def test_members_of_an_ensemble_are_the_models(models):
    ensemble = stack_models(models)
    assert ensemble.count == len(models) == 6
    np.testing.assert_array_equal(ensemble.model.mass[:, 0], [1, 1, 2, 2, 3, 3])
    assert ensemble.model.T00.shape == (6, 1, 3, 3)
    for k, model in enumerate(models):
        found = member(ensemble, k)
        assert isinstance(found, Model)
        for name, one, other in zip(FIELDS, leaves(found), leaves(model), strict=True):
            assert type(one) is type(other), name
            np.testing.assert_array_equal(one, other, err_msg=name)
            if isinstance(one, np.ndarray):
                assert one.dtype == other.dtype, name
                assert one.flags.c_contiguous, name


def test_members_are_views(models):
    ensemble = stack_models(models)
    member(ensemble, 1).mass[0] = 7.0
    assert ensemble.model.mass[1, 0] == 7.0
    assert member(ensemble, 0).mass[0] == 1.0


def test_another_structure_is_refused(models):
    other = models[1]._replace(redundant=1)
    assert structure(models[0]) == structure(models[1]) != structure(other)
    with pytest.raises(ValueError, match="member 1: redundant differs"):
        stack_models([models[0], other])


@pytest.fixture
def three(tmp_path):
    """Members prepared for radau, and their settings."""
    plan = ball_plan(tmp_path, f"{MASS} = [1, 2, 3]", 'variants = ["implicit"]')
    mechanisms = [plan.mechanism_of(k) for k in range(3)]
    return [prepare(m, {}) for m in mechanisms], mechanisms[0]["solver"]


def together(members, solver, watches):
    models, y0s = [m.model for m in members], [m.y0 for m in members]
    times = np.linspace(0.0, solver["t_end"], 5)
    return integrate_members(models, y0s, solver, times, watches, members[0].treatment)


def test_members_move_as_they_do_alone(three):
    members, solver = three
    found = together(members, solver, [m.watch for m in members])
    assert solver["integrator"] == "radau"
    for one, solution in zip(members, found, strict=True):
        # step by step as well: output inside a step then comes from the same formula
        alone = integrate(make_integrator(one.model, one.y0, solver), solution.t, lambda _: None)
        assert solution.status == alone.status == "finished"
        np.testing.assert_array_equal(solution.y, alone.y)
    # force t^3 on masses 1, 2, 3: a velocity of 1 + t^4 / (4 m) at the end
    ends = [s.y[-1, m.model.n_pos] for s, m in zip(found, members, strict=True)]
    np.testing.assert_allclose(ends, 1.0 + 0.25 / np.array([1.0, 2.0, 3.0]), rtol=1e-6)


def test_an_error_in_one_member_leaves_the_others_alone(three):
    members, solver = three

    def broken(integrator):
        raise ArithmeticError("seven")

    found = together(members, solver, [members[0].watch, broken, members[2].watch])
    assert [type(one) for one in found] == [Solution, ArithmeticError, Solution]
    assert found[0].status == found[2].status == "finished"


def test_interruption_keeps_finished_members(three):
    members, solver = three

    def impatient(integrator):
        raise KeyboardInterrupt

    found = together(members, solver, [members[0].watch, impatient, members[2].watch])
    assert [one.status for one in found] == ["finished", "interrupted"]
