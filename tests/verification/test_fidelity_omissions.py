"""A plan that lacks something: its own check sees it, and says how much it costs."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from samples.fidelity_samples import Table, pendulum, planned_run, true_signals

from plymotion.solver.studies.fidelity.answer import Answer
from plymotion.solver.studies.fidelity.checked_run import plan_of
from plymotion.solver.studies.fidelity.checking import Checking
from plymotion.solver.studies.fidelity.comparison import difference, scales
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan

ACCURACY = 1e-5
T_END = 0.025  # [s] of the scene
BUDGET = 60.0  # CPU seconds
SIGNALS = ["tip_y", "bending"]
LABELS = ("bending-xy 1", "bending-xy 2", "bending-xy 3")
WHOLE = Plan({"link0": BodyPlan(LABELS, 4, True)}, True, 1e-7)
# What is left out of the plan, or of the packages of its model.
PLANS = {
    "nothing": WHOLE,
    "mode": WHOLE.with_body("link0", vibrations=LABELS[1:]),
    "statics": WHOLE.with_body("link0", static=0),
    "tolerance": replace(WHOLE, rtol=1e-2),
    "stiffening": replace(WHOLE, stiffening=False),
    "attachment": WHOLE,
    "mesh": WHOLE,
}
PACKAGES = {"attachment": {"without": "attachment"}, "mesh": {"elements": 2}}


def scene() -> Table:
    return pendulum(t_end=T_END, signals=SIGNALS, accuracy=ACCURACY)


@cache
def truth() -> np.ndarray:
    """Signals (o, k) of the scene."""
    found = true_signals(scene(), "soft", 1e-8)
    return np.array([found[name] for name in SIGNALS])


def judged(missing: str) -> tuple[Answer, float, float]:
    """Return the answer for a plan that lacks something, its estimate and its true error.

    The check alone: what `checked` runs after a refusal changes neither (test_fidelity_refusals).
    """
    answer = plan_of(*planned_run(scene(), "soft", **PACKAGES.get(missing, {})))
    answer.plan = PLANS[missing]
    Checking(answer, ACCURACY, "pointwise", BUDGET).settled()
    assert answer.trial is not None
    assert answer.estimate is not None
    exact = truth()
    true = difference("pointwise", answer.trial.signals, exact) / scales("pointwise", exact)
    return answer, float(answer.estimate.max()), float(true.max())


def test_a_plan_that_lacks_nothing_is_accepted() -> None:
    answer, estimate, true = judged("nothing")
    assert answer.verdict == "met"
    assert true <= estimate <= ACCURACY


@pytest.mark.parametrize("missing", [name for name in PLANS if name != "nothing"])
def test_an_omission_is_refused_with_its_size(missing: str) -> None:
    answer, estimate, true = judged(missing)
    assert true > ACCURACY
    assert answer.verdict == "not met"
    assert 0.5 <= estimate / true <= 2.0
