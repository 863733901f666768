"""Indicators of a plan: what they say of rigid bodies, and the mechanism that they use."""

import numpy as np
import pytest
from samples.fidelity_samples import pendulum, planned_run, true_signals

from plymotion.solver.dynamics.evaluation.variations import residuals
from plymotion.solver.mechanism.build import build
from plymotion.solver.studies.fidelity.comparison import difference, scales
from plymotion.solver.studies.fidelity.execution import plan_of
from plymotion.solver.studies.fidelity.indicators.loaded import without_second_order
from plymotion.solver.studies.fidelity.indicators.response import samples
from plymotion.solver.studies.fidelity.plan import with_values


@pytest.mark.parametrize("signal", ["force", "bending", "tip_y"])
def test_the_indicated_loss_of_rigid_bodies_is_near_the_true_one(signal: str) -> None:
    table = pendulum(links=2, signals=[signal])
    table["solver"]["start"] = "quasi-static"
    found = plan_of(*planned_run(table, "soft")).study.indicators
    exact = true_signals(table, "soft", 1e-7)[signal][None]
    true = difference("pointwise", found.effects.base, exact) / scales("pointwise", exact)
    indicated = found.loss(found.effects.response.sum(axis=2))
    assert 0.3 < indicated[0] / true[0] < 3.0
    left = difference("pointwise", found.effects.whole, exact) / scales("pointwise", exact)
    assert left[0] < 0.7 * true[0]


def test_a_model_without_second_order_is_that_of_linear_bodies() -> None:
    spec, _ = planned_run(pendulum(links=2), "soft")
    models = [
        build(
            with_values(
                spec.mechanism,
                solver=with_values(spec.mechanism.solver, geometric_stiffening=stiffening),
            ),
            dict(spec.packages),
        ).model
        for stiffening in (False, True)
    ]
    linear, stripped = models[0], without_second_order(models[1])
    rng = np.random.default_rng(3)
    y = np.zeros((4, linear.n_pos + linear.n_vel + 1))
    y[:, : linear.n_pos] = 1e-3 * rng.normal(size=(4, linear.n_pos))
    for first in linear.pos_start.tolist():
        y[:, first + 3] = 1.0
    y[:, linear.n_pos : -1] = rng.normal(size=(4, linear.n_vel))
    a = rng.normal(size=(4, linear.n_vel))
    forces = rng.normal(size=(4, linear.n_constraint))
    left = [residuals(model, np.zeros(4), y, a, forces) for model in (linear, stripped, models[1])]
    size = np.abs(left[0]).max()
    assert np.abs(left[1] - left[0]).max() < 1e-12 * size
    assert np.abs(left[2] - left[0]).max() > 1e-6 * size


def test_samples_follow_the_rotation_of_the_bodies() -> None:
    slow, fast = (
        plan_of(*planned_run(pendulum(speed=speed), "stiff")).study.base for speed in (1.0, 40.0)
    )
    assert len(samples(slow)) < len(samples(fast))
    for base in (slow, fast):
        assert samples(base)[0] == 0
        assert samples(base)[-1] == len(base.t) - 1
