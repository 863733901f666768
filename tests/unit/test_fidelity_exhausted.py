"""Where a check is blind: kinds of vibrations of which its package has no more."""

import numpy as np
import pytest

from plymotion.solver.studies.fidelity.checking import exhausted, power_of, tail
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan, outline

RANKED = {"arm": ("bending-xy 1", "bending-xy 2", "axial 1")}
PACKAGE = {"arm": ("bending-xy 1", "bending-xy 2", "bending-xy 3", "axial 1", "torsion 1")}


def check(*labels):
    return Plan({"arm": BodyPlan(labels, 2)}, True, 1e-5)


def test_a_check_is_not_blind_if_its_package_has_more():
    assert exhausted(check("bending-xy 1", "bending-xy 2"), RANKED, PACKAGE) == {}


def test_kinds_of_which_a_check_has_all():
    every = ("bending-xy 1", "bending-xy 2", "bending-xy 3")
    assert exhausted(check(*every), RANKED, PACKAGE) == {"arm": ("bending-xy",)}
    assert exhausted(check(*every, "axial 1"), RANKED, PACKAGE) == {"arm": ("bending-xy", "axial")}


def test_kinds_that_do_not_respond_are_left_out():
    assert exhausted(check("torsion 1"), RANKED, PACKAGE) == {}


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
