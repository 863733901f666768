"""The table of force elements: every number leads to its kind; what a file must say."""

import numpy as np
import pytest

from plymotion.solver.dynamics.elements.forces.contract import (
    N_ELEMENT_ROW,
    Element,
    Load,
    Number,
    OfTime,
)
from plymotion.solver.dynamics.elements.forces.spring import spring, spring_rows
from plymotion.solver.dynamics.elements.forces.table import (
    ELEMENTS,
    FIRST_LOAD,
    FORCES,
    KINDS,
    MOST_ROWS,
    N_PARAMETER,
    element_rows,
    element_wrench,
    rows_in_use,
)


def _marker(rng):
    """A row of model/motion.py with axes of a rotation."""
    motion = rng.normal(size=24)
    motion[3:12] = np.linalg.qr(rng.normal(size=(3, 3)))[0].ravel()
    if np.linalg.det(motion[3:12].reshape(3, 3)) < 0.0:
        motion[3:12] *= -1.0
    return motion


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_leads_to_its_kind(kind):
    rng = np.random.default_rng(1)
    one, two = _marker(rng), _marker(rng)
    parameters = rng.uniform(0.5, 2.0, N_PARAMETER)
    number, element = KINDS[kind], FORCES[kind]
    found = element_wrench(number, one, two, parameters, 0.7)
    assert found == element.wrench(one, two, parameters, 0.7)
    assert (number >= FIRST_LOAD) == isinstance(element, Load)
    in_use = rows_in_use(kind, parameters)
    if isinstance(element, Element) and element.rows is not None:
        assert set(in_use) <= set(range(element.most_rows))
        rows = [np.full((MOST_ROWS, N_ELEMENT_ROW), np.nan) for _ in range(2)]
        element_rows(number, one, two, parameters, rows[0])
        element.rows(one, two, parameters, rows[1])
        np.testing.assert_array_equal(*rows)
        assert np.isfinite(rows[0][: element.most_rows]).all()
        assert element.rows_in_use([0.0] * N_PARAMETER) == []
    else:
        assert in_use == []
        rows = np.full((MOST_ROWS, N_ELEMENT_ROW), np.nan)
        element_rows(number, one, two, parameters, rows)
        assert np.isnan(rows).all()


def test_numbers_follow_the_keys():
    bushing = ELEMENTS["bushing"]
    given = {key: [k, k, k] for k, key in enumerate(("stiffness", "rotary_stiffness"), start=1)}
    given |= {key: [k, k, k] for k, key in enumerate(("damping", "rotary_damping"), start=3)}
    assert bushing.numbers(given, np.zeros(3)) == (1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4)
    assert len(bushing.parameters) == 12
    given = {"stiffness": 1.0, "damping": 2.0, "length": None}
    assert ELEMENTS["spring"].numbers(given, np.array([3.0, 0.0, 4.0])) == (1.0, 2.0, 5.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"wrench": lambda one, two: None}, "its wrench takes"),
        ({"rows": spring_rows}, "expected `rows` and `most_rows`, or neither"),
        ({"acts_by": ("strength",)}, "acts_by"),
        ({"keys": (OfTime("a", ""), OfTime("b", ""))}, "expected one at most"),
    ],
)
def test_a_file_that_does_not_keep_the_contract_is_refused(changes, words):
    keys = (Number("k", "N/m", "stiffness", required=True),)
    given = {"kind": "toy", "meaning": "of a test", "keys": keys, "wrench": spring}
    assert Element(**given).parameters == ("k",)
    with pytest.raises(ValueError, match=words):
        Element(**given | changes)
