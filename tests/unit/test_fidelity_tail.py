"""What vibrations above those of the packages contribute; words for a plan."""

import numpy as np
import pytest

from plymotion.solver.studies.fidelity.checking import power_of, tail
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan, outline


@pytest.mark.parametrize(("m", "n"), [(4, 6), (2, 3), (4, 12)])
@pytest.mark.parametrize("kind", ["deflection", "reaction"])
def test_the_tail_of_contributions_that_decrease_with_the_power(m, n, kind):
    c = np.arange(1, 200001) ** -power_of(kind)
    assert tail(m, n, power_of(kind)) == pytest.approx(c[n:].sum() / c[m:n].sum(), rel=2e-2)


def test_no_tail_without_a_vibration_to_compare_with():
    assert tail(4, 4) == 0.0


def test_the_outline_of_a_plan():
    found = Plan({"arm": BodyPlan(("bending-xy 1",), 2, True), "hand": BodyPlan()}, True, 1e-5)
    assert outline(found) == "arm 1+2 undamped, hand rigid, stiffening, rtol 1e-05"
