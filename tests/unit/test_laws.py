"""Laws of time: values, rates and continuity."""

import numpy as np
import pytest

from plymotion.solver.math import laws


def value(law, t):
    start = np.array([0, len(law.times)])
    return np.array(laws.law_value(start, law.times, law.coefficients, 0, t))


def test_polynomial_and_its_rates():
    law = laws.polynomial([1.0, 2.0, 3.0])
    assert value(law, 2.0) == pytest.approx([17.0, 14.0, 6.0])
    assert value(law, -1.0) == pytest.approx([2.0, -4.0, 6.0])


@pytest.mark.parametrize(
    "law",
    [
        laws.smooth_step(4.0, 0.5, start=0.2),
        laws.ramp(3.0, 0.8, offset=0.1),
        laws.table([0.0, 0.3, 0.5, 1.1], [1.0, -1.0, 2.0, 0.5]),
    ],
    ids=["smooth step", "ramp", "table"],
)
def test_rates_are_derivatives_and_pieces_join(law):
    h = 1e-5
    for t in np.linspace(0.01, 1.05, 57):
        f, f_d, f_dd = value(law, t)
        before, after = value(law, t - h), value(law, t + h)
        if not np.any(np.abs(law.times - t) < 2 * h):
            assert (after[0] - before[0]) / (2 * h) == pytest.approx(f_d, abs=1e-5)
            assert (after[1] - before[1]) / (2 * h) == pytest.approx(f_dd, abs=1e-4)
        assert after[0] == pytest.approx(f, abs=1e-3)
    for t in law.times[1:-1]:
        assert value(law, t - 1e-12) == pytest.approx(value(law, t), abs=1e-6)


def test_smooth_step_ends_on_its_value_at_rest():
    law = laws.smooth_step(4.0, 0.5, start=0.2)
    assert value(law, 0.0) == pytest.approx([0.0, 0.0, 0.0])
    assert value(law, 0.45)[0] == pytest.approx(2.0)
    assert value(law, 9.0) == pytest.approx([4.0, 0.0, 0.0])


def test_ramp_reaches_its_speed():
    law = laws.ramp(3.0, 0.8, offset=0.1)
    assert value(law, 0.0) == pytest.approx([0.1, 0.0, 0.0])
    assert value(law, 0.8) == pytest.approx([0.1 + 1.2, 3.0, 0.0])
    assert value(law, 1.8) == pytest.approx([0.1 + 1.2 + 3.0, 3.0, 0.0])


def test_sine_ramp_has_the_closed_form():
    law, w = laws.ramp(6.0, 15.0, 0.3, sine=True), 2 * np.pi / 15.0
    for t in np.linspace(0.0, 15.0, 101):
        exact = [0.3 + 0.2 * t**2 + 0.4 * (np.cos(w * t) - 1.0) / w**2]
        exact += [0.4 * (t - np.sin(w * t) / w), 0.4 * (1.0 - np.cos(w * t))]
        assert value(law, t) == pytest.approx(exact, rel=1e-11, abs=1e-10)
    assert value(law, 20.0) == pytest.approx([75.3, 6.0, 0.0], rel=1e-11, abs=1e-10)


def test_table_passes_its_points_and_holds_the_last():
    times, values = [0.0, 0.3, 0.5, 1.1], [1.0, -1.0, 2.0, 0.5]
    for interpolation in ("linear", "pchip", "spline"):
        law = laws.table(times, values, interpolation)
        assert [value(law, t)[0] for t in times] == pytest.approx(values)
        assert value(law, 5.0) == pytest.approx([0.5, 0.0, 0.0])
    assert value(laws.table(times, values, "linear"), 0.4) == pytest.approx([0.5, 15.0, 0.0])


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([0.0, 1.0], [1.0, np.nan], r"values\[1\] = nan: expected a finite number"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], r"times\[2\] = 1: expected more than 1"),
        ([0.0], [1.0], "two at least"),
        ([0.0, 1.0], [1.0], "as many values as times"),
    ],
)
def test_wrong_tables(times, values, message):
    with pytest.raises(ValueError, match=message):
        laws.table(times, values)
