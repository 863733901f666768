"""Indicators of a plan: what they say of rigid bodies, and the mechanism that they use."""

import pytest
from samples.fidelity_samples import pendulum, planned_run, true_signals

from plymotion.solver.studies.fidelity.checked_run import plan_of
from plymotion.solver.studies.fidelity.comparison import difference, scales
from plymotion.solver.studies.fidelity.indicators.response import samples


@pytest.mark.parametrize("signal", ["force", "bent", "tip_y"])
def test_the_indicated_loss_of_rigid_bodies_is_near_the_true_one(signal: str) -> None:
    table = pendulum(links=2, signals=[signal])
    table["solver"]["start"] = "quasi-static"
    table["signals"]["bent"] = {**table["signals"]["bending"], "component": "magnitude"}
    found = plan_of(*planned_run(table, "soft")).study.indicators
    exact = true_signals(table, "soft", 1e-7)[signal][None]
    true = difference("pointwise", found.effects.base, exact) / scales("pointwise", exact)
    indicated = found.loss(found.effects.response.sum(axis=2))
    assert 0.3 < indicated[0] / true[0] < 3.0
    left = difference("pointwise", found.effects.whole, exact) / scales("pointwise", exact)
    assert left[0] < 0.7 * true[0]


def test_samples_follow_the_rotation_of_the_bodies() -> None:
    slow, fast = (
        plan_of(*planned_run(pendulum(speed=speed), "stiff")).study.base for speed in (1.0, 40.0)
    )
    assert len(samples(slow)) < len(samples(fast))
    for base in (slow, fast):
        assert samples(base)[0] == 0
        assert samples(base)[-1] == len(base.t) - 1
