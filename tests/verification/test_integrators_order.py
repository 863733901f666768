"""Observed order and absolute error at fixed steps, of the steps and of the dense output."""

import numpy as np
import pytest

from plymotion.solver.integrators.explicit import RungeKutta5, RungeKutta8
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.generic.gear import Gear
from plymotion.solver.integrators.table import new_integrator


def exact(t):
    """A point on a circle whose angle grows as t + sin t."""
    angle = np.asarray(t) + np.sin(t)
    return np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def circle(t, y):
    speed = 1 + np.cos(t)
    return speed * np.array([-y[1], y[0]])


def errors(make, n_steps, t_end):
    """Largest error at the steps' ends, and midway between them by dense output."""
    at_steps, between = [], []
    for n in n_steps:
        integrator = make(t_end / n)
        midway = (np.arange(n) + 0.5) * t_end / n
        seen = []
        solution = integrate(
            integrator, midway, lambda i, seen=seen: seen.append((i.t, i.y.copy())) or None
        )
        assert integrator.status == "finished"
        assert integrator.counters.steps == n
        at_steps.append(max(np.abs(y - exact(t)).max() for t, y in seen))
        between.append(np.abs(solution.y - exact(solution.t)).max())
    return np.array(at_steps), np.array(between)


def observed(error, n_steps):
    return np.log(error[0] / error[-1]) / np.log(n_steps[-1] / n_steps[0])


@pytest.mark.parametrize(
    ("order", "largest"), [(1, 6e-2), (2, 2e-3), (3, 2e-4), (4, 2e-5), (5, 4e-6)]
)
def test_gear_fixed_order(order, largest):
    def make(h):
        past = -h * np.arange(order - 1, 0, -1.0)
        return Gear(
            circle,
            0.0,
            exact(0.0),
            2.0,
            fixed_step=h,
            fixed_order=order,
            past=(past, exact(past)),
            rtol=1e-12,
            atol=1e-14,
        )

    n_steps = (80, 160) if order < 5 else (60, 120)
    at_steps, between = errors(make, n_steps, 2.0)
    assert observed(at_steps, n_steps) == pytest.approx(order, abs=0.25)
    assert observed(between, n_steps) > order - 0.25
    assert at_steps[-1] < largest
    assert between[-1] < 1.5 * largest


@pytest.mark.parametrize(
    ("method", "order", "dense_order", "n_steps", "largest"),
    [(RungeKutta5, 5, 4, (40, 80), 3e-8), (RungeKutta8, 8, 7, (10, 20), 2e-8)],
)
def test_runge_kutta_fixed_step(method, order, dense_order, n_steps, largest):
    def make(h):
        return method(circle, 0.0, exact(0.0), 4.0, fixed_step=h)

    at_steps, between = errors(make, n_steps, 4.0)
    assert observed(at_steps, n_steps) > order - 0.4
    assert (
        observed(between, n_steps) > dense_order - 0.4
    )  # a global error of h^dense_order or better
    assert at_steps[-1] < largest
    assert between[-1] < 20 * largest


@pytest.mark.parametrize("name", ["gear", "rk5", "rk8"])
def test_error_is_proportional_to_the_tolerance(name):
    """Two decades tighter: the error falls by about two decades, and stays near the tolerance."""
    t = np.linspace(0, 10, 101)
    measured = []
    tolerances = [1e-4, 1e-6, 1e-8, 1e-10]
    for tolerance in tolerances:
        integrator = new_integrator(
            name, circle, 0.0, exact(0.0), 10.0, rtol=tolerance, atol=tolerance
        )
        measured.append(np.abs(integrate(integrator, t).y - exact(t)).max())
    slope = np.polyfit(np.log10(tolerances), np.log10(measured), 1)[0]
    assert 0.75 < slope < 1.25
    assert all(e < 100 * tol for e, tol in zip(measured, tolerances, strict=True))
