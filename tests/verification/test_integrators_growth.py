"""BDF of order 3 and above amplifies an undamped oscillation; cap and error control prevent it."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.generic.gear import Gear

REFERENCE = Path(__file__).parents[1] / "reference" / "integrators" / "bdf_growth.toml"
TABLE = tomllib.loads(REFERENCE.read_text())
ROWS = [
    (int(order), w_h, growth)
    for order, row in TABLE["growth_per_step"].items()
    for w_h, growth in zip(TABLE["w_h"], row, strict=True)
]


def oscillator(t, y):
    return np.array([y[1], -y[0]])


def amplitudes(order, w_h, n_step):
    """|y| after each step of h = w_h (w = 1), started from exact points."""
    past = -w_h * np.arange(order - 1, 0, -1.0)
    gear = Gear(
        oscillator,
        0.0,
        np.array([1.0, 0.0]),
        n_step * w_h,
        fixed_step=w_h,
        fixed_order=order,
        past=(past, np.column_stack((np.cos(past), -np.sin(past)))),
        rtol=1e-12,
        atol=1e-300,
    )
    values = []
    while gear.status == "running":
        gear.step()
        values.append(np.hypot(*gear.y))
    return np.array(values), gear


@pytest.mark.parametrize(("order", "w_h", "growth"), ROWS)
def test_growth_per_step_is_that_of_the_characteristic_root(order, w_h, growth):
    values, gear = amplitudes(order, w_h, 600)
    measured = (values[-1] / values[-80]) ** (1 / 79)
    assert measured == pytest.approx(growth, rel=TABLE["tolerance_relative"])
    steps = 600 if growth**600 < 1e12 else np.log(1e12) / np.log(growth)
    assert gear.counters.steps == pytest.approx(steps, abs=30)


def test_order_2_decays_where_order_3_ends_with_words():
    """1.0436 a step would be 3.4e18 in 1000 steps; the run ends where it has grown 1e12-fold."""
    values, gear = amplitudes(2, 1.0, 1000)
    assert gear.status == "finished"
    assert values[-1] < 1e-29
    values, gear = amplitudes(3, 1.0, 1000)
    assert gear.status == "failed"
    assert 1e12 < values[-1] < 2e12  # the amplitude; a component has grown 1e12-fold
    assert "diverges" in gear.message
    assert "max_order = 2" in gear.message


@pytest.mark.parametrize("max_order", [2, 5])
def test_cap_or_error_control_keeps_an_undamped_mode_bounded(max_order):
    t = np.linspace(0, 200, 400)
    gear = Gear(
        oscillator, 0.0, np.array([1.0, 0.0]), 200.0, max_order=max_order, rtol=1e-4, atol=1e-6
    )
    solution = integrate(gear, t)
    assert solution.status == "finished"
    assert np.hypot(*solution.y.T).max() < 1.05


def test_order_2_lets_an_unresolved_undamped_mode_die_out():
    """A slow motion with a fast mode 1e4 times as stiff: large steps, no growth."""

    def slow_and_fast(t, y):
        return np.array([y[1], -y[0], y[3], -1e8 * y[2]])

    gear = Gear(
        slow_and_fast,
        0.0,
        np.array([1.0, 0.0, 1e-9, 0.0]),
        20.0,
        max_order=2,
        rtol=1e-5,
        atol=np.array([1e-8, 1e-8, 1e-6, 1e-3]),
    )
    solution = integrate(gear, [0.0, 20.0])
    assert solution.status == "finished"
    assert abs(solution.y[-1, 2]) < 1e-9
    assert solution.counters.steps < 20 * 1e4 / 10  # far fewer than the fast mode's periods want
    assert solution.y[-1, 0] == pytest.approx(np.cos(20.0), abs=5e-3)
