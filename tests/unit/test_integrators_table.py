"""The table of integrators: what a class must say of itself, and what is refused."""

import numpy as np
import pytest

from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.integrators.contract import Integrator, Number
from plymotion.solver.integrators.table import INTEGRATORS, _check, named


def kind(**attributes):
    return type("Toy", (Integrator,), {"name": "toy", "meaning": "of a test", **attributes})


@pytest.mark.parametrize("known", INTEGRATORS.values(), ids=INTEGRATORS)
def test_every_integrator_of_the_table_keeps_the_contract(known):
    assert isinstance(known.order, int)
    words = (known.meaning, known.on_growth, known.on_failure, known.on_any_failure)
    assert not any(text.endswith(".") for text in words)
    assert known.on_failure


def test_the_manual_begins_with_our_own():
    names = list(INTEGRATORS)
    assert names[:5] == ["gear", "radau", "rk8", "rk5", "generalized-alpha"]
    places = [kind.place for kind in INTEGRATORS.values()]
    assert (np.diff(places) >= 0).all()


@pytest.mark.parametrize(
    ("attributes", "words"),
    [
        ({"meaning": ""}, "integrator toy: expected a `meaning`"),
        ({"takes": "derivatives"}, "integrator toy: takes: expected one of"),
        ({"keys": (Number("size", "", "of nothing"),)}, "key size: expected one of.*rtol"),
    ],
)
def test_a_class_that_does_not_keep_it_is_refused(attributes, words):
    with pytest.raises(ValueError, match=words):
        _check(kind(**attributes))


def test_two_of_one_name_are_refused():
    with pytest.raises(ValueError, match="integrator 'toy' is defined twice"):
        named([kind(), kind()])


@pytest.mark.parametrize("name", ["scipy-bdf", "ida"])
def test_an_integrator_of_another_code_is_refused(name):
    keys = {"t_end": 1.0, "output_step": 0.1, "integrator": name}
    with pytest.raises(ValueError, match=f"'gear', 'radau'.*input_value='{name}'"):
        Solver.model_validate(keys)
