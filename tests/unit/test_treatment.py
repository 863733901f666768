"""Choosing a treatment: defaults, combinations, messages."""

import pytest
from samples.mechanism_samples import pendulum

from plymotion.solver.dynamics.elements.constraints.treatment import TREATMENTS, Treatment
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.integrators.table import treatment_of
from plymotion.solver.mechanism.assembly import treated


def solver(**keys):
    return Solver.model_validate({"t_end": 1.0, "output_step": 0.1, **keys})


def test_default_and_explicit_choice():
    assert vars(treatment_of(solver())) == vars(Treatment())
    treatment = treatment_of(solver(integrator="gear", constraints="baumgarte", alpha=4.0))
    assert (treatment.name, treatment.alpha, treatment.beta) == ("baumgarte", 4.0, 5.0)


def test_parameters_are_read():
    keys = {"constraints": "augmented-lagrangian", "penalty": 1e5, "frequency": 20.0, "ratio": 0.7}
    treatment = treatment_of(solver(integrator="rk8", **keys))
    model = treated(pendulum().model, treatment)
    assert (model.penalty, model.alpha, model.beta) == (1e5, 14.0, 20.0)


def test_another_name_is_refused():
    with pytest.raises(ValueError, match="did you mean 'baumgarte'"):
        Treatment("baumgart")


def test_only_its_own_parameters_reach_the_step_loop():
    given = {name: treated(pendulum().model, Treatment(name)) for name in TREATMENTS}
    for name in ("index1", "projection", "ggl", "index3"):
        assert (given[name].alpha, given[name].beta) == (0.0, 0.0)
    assert (given["baumgarte"].alpha, given["baumgarte"].beta) == (5.0, 5.0)
    assert [name for name, m in given.items() if m.penalty > 0] == [
        "augmented-lagrangian",
        "projection",
    ]


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"constraints": "ggl", "integrator": "rk8"}, 'expected integrator = "generalized-alpha"'),
        ({"constraints": "projection", "integrator": "generalized-alpha"}, "gear.*ggl or index3"),
        ({"constraints": "index3", "integrator": "gear"}, 'expected integrator = "general.*alpha"'),
    ],
)
def test_what_does_not_go_together_is_refused(keys, words):
    with pytest.raises(InputError, match=words) as error:
        treatment_of(solver(**keys))
    assert "solver.constraints" in str(error.value)
