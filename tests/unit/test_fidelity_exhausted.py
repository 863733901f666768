"""Where a check is blind: kinds of vibrations of which no package has more."""

from plymotion.solver.fidelity.exhausted import exhausted
from plymotion.solver.fidelity.plan import BodyPlan, Plan, outline

RANKED = {"arm": ("bending-xy 1", "bending-xy 2", "axial 1")}


def plan(*labels):
    return Plan({"arm": BodyPlan(labels, 2)}, True, 1e-5)


def test_a_check_with_more_of_each_kind_is_not_blind():
    check = plan("bending-xy 1", "bending-xy 2", "axial 1")
    assert exhausted(plan("bending-xy 1"), check, RANKED) == {}


def test_the_highest_vibration_of_a_kind_that_the_check_has_no_more_of():
    labels = [f"bending-xy {k}" for k in range(1, 11)]
    check = plan(*labels, "axial 1")
    assert exhausted(plan(*labels), check, RANKED) == {"arm": ("bending-xy 10",)}
    assert exhausted(plan(*labels, "axial 1"), check, RANKED) == {
        "arm": ("bending-xy 10", "axial 1")
    }


def test_kinds_that_do_not_respond_are_left_out():
    labels = ("bending-xy 1", "torsion 1")
    check = plan(*labels, "bending-xy 2")
    assert exhausted(plan(*labels), check, RANKED) == {}


def test_the_outline_of_a_plan():
    found = Plan({"arm": BodyPlan(("bending-xy 1",), 2, True), "hand": BodyPlan()}, True, 1e-5)
    assert outline(found) == "arm 1+2 undamped, hand rigid, stiffening, rtol 1e-05"
