"""Models of one structure stacked along a leading axis."""

import numpy as np
import pytest
from sweep_samples import FORCE, MASS, ball_plan

from plymotion.solver.ensemble import member, stack_models, structure
from plymotion.solver.model import Model
from plymotion.solver.plan import Plan
from plymotion.solver.preparation import prepare

FIELDS = tuple(name for name in Model._fields if name != "plan") + Plan._fields


def leaves(model):
    """The numbers and arrays of a model, in the order of FIELDS."""
    return (*(value for value in model if value is not model.plan), *model.plan)


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
