"""A two-link arm with geared PID joints, default settings, against its equations in SciPy.

Friction of Stribeck, gravity and a payload; the limits of the motors act in both cases.
"""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, run
from scipy.integrate import solve_ivp

M_1, C_1, J_1, L_1 = 4.0, 0.25, 0.09, 0.5
M_2, C_2, J_2, L_2, LOAD = 2.5, 0.2, 0.04, 0.4, 1.5
G, T_END, STEP = 9.81, 0.6, 0.02
SHOULDER = {"kp": 12.0, "ki": 5.0, "kd": 0.6, "tf": 0.01, "low": -0.4, "high": 1.0, "gear": 50.0}
ELBOW = {"kp": 4.0, "ki": 0.0, "kd": 0.2, "tf": 0.005, "low": -0.3, "high": 0.3, "gear": 80.0}
PERIODS = 0.002, 0.003


def motor(joint, setpoint, c, period):
    sampled = f"sample_time = {period}" if period else ""
    return f"""
[forces.{joint}_motor]
kind = "controller"
joint = "{joint}"
setpoint = "{setpoint}"
proportional = {c["kp"]}
integral = {c["ki"]}
derivative = {c["kd"]}
filter_time = {c["tf"]}
lower = {c["low"]}
upper = {c["high"]}
gear_ratio = {c["gear"]}
{sampled}
[signals.{joint}]
kind = "joint"
joint = "{joint}"
coordinate = "angle"
"""


def case(periods):
    axis = "axis = [0.0, -1.0, 0.0]"
    return (
        f"gravity = [0.0, 0.0, -{G}]\n"
        + rigid("upper", M_1, [0.01, J_1, J_1], {"a": (0, 0, 0), "b": (L_1, 0, 0)},
                centre=(C_1, 0, 0))
        + rigid("fore", M_2, [0.01, J_2, J_2], {"a": (0, 0, 0), "b": (L_2, 0, 0)},
                centre=(C_2, 0, 0), position=(L_1, 0, 0))
        + f"""
[ground.base]
position = [0.0, 0.0, 0.0]
[masses.load]
mass = {LOAD}
at = "fore.b"
[joints.shoulder]
kind = "revolute"
between = ["ground.base", "upper.a"]
{axis}
[joints.elbow]
kind = "revolute"
between = ["upper.b", "fore.a"]
{axis}
[forces.bearing]
kind = "friction"
joint = "shoulder"
coulomb = 2.0
static = 3.0
stribeck_velocity = 0.05
viscous = 0.5
rest_velocity = 0.01
"""
        + motor("shoulder", "0.8 * smooth_step(t, 0, 0.4)", SHOULDER, periods and periods[0])
        + motor("elbow", "-0.5 * sin(3 * t)", ELBOW, periods and periods[1])
    )  # fmt: skip


def accelerations(q, w, outputs):
    """Of the angles q = (shoulder, elbow), for the outputs of both motors."""
    end, first = M_2 + LOAD, M_2 * C_2 + LOAD * L_2
    fore = J_2 + M_2 * C_2**2 + LOAD * L_2**2
    upper = J_1 + M_1 * C_1**2 + end * L_1**2
    c, s = np.cos(q[1]), np.sin(q[1])
    one, two = upper + fore + 2.0 * L_1 * first * c, fore + L_1 * first * c
    h = L_1 * first * s
    weight = first * G * np.cos(q[0] + q[1])
    friction = (2.0 + np.exp(-((w[0] / 0.05) ** 2))) * np.tanh(w[0] / 0.01) + 0.5 * w[0]
    f_1 = SHOULDER["gear"] * outputs[0] - friction + h * (2.0 * w[0] * w[1] + w[1] ** 2)
    f_1 -= (M_1 * C_1 + end * L_1) * G * np.cos(q[0]) + weight
    f_2 = ELBOW["gear"] * outputs[1] - h * w[0] ** 2 - weight
    det = one * fore - two**2
    return (fore * f_1 - two * f_2) / det, (one * f_2 - two * f_1) / det


def setpoints(t):
    s = min(t / 0.4, 1.0)
    return 0.8 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5), -0.5 * np.sin(3.0 * t)


def act(c, error, integral, filtered, lag):
    """Output of a controller, and the rate of its integral part."""
    demand = c["kp"] * error + integral + c["kd"] * (error - filtered) / lag
    output = min(max(demand, c["low"]), c["high"])
    back = (output - demand) * c["ki"] / c["kp"]
    return output, c["ki"] * error + back


def continuous(times):
    def rate(t, y):
        q, w, integral, filtered = y[:2], y[2:4], y[4:6], y[6:]
        errors = np.array(setpoints(t)) - q
        outputs, rates, lags = [], [], []
        for k, c in enumerate((SHOULDER, ELBOW)):
            output, rising = act(c, errors[k], integral[k], filtered[k], c["tf"])
            outputs.append(output)
            rates.append(rising)
            lags.append((errors[k] - filtered[k]) / c["tf"])
        return [*w, *accelerations(q, w, outputs), *rates, *lags]

    return solve_ivp(rate, (0.0, T_END), np.zeros(8), "LSODA", times, rtol=1e-8, atol=1e-10).y[:2]


def held(times):
    """Controllers of 2 ms and 3 ms: backward differences in the filter, forward in the integral."""
    y, found = np.zeros(4), [np.zeros(2)]
    integral, filtered, outputs = [0.0] * 2, [0.0] * 2, [0.0] * 2
    for ms in range(round(T_END * 1000)):
        for k, (c, period) in enumerate(zip((SHOULDER, ELBOW), PERIODS, strict=True)):
            if ms % round(1000 * period) == 0:
                error = setpoints(ms * 1e-3)[k] - y[k]
                outputs[k], rising = act(c, error, integral[k], filtered[k], c["tf"] + period)
                integral[k] += period * rising
                filtered[k] = (c["tf"] * filtered[k] + period * error) / (c["tf"] + period)
        for _ in range(4):
            y = runge_kutta(y, outputs, 0.25e-3)
        if (ms + 1) % round(STEP * 1000) == 0:
            found.append(y[:2])
    assert len(found) == len(times)
    return np.array(found).T


def runge_kutta(y, outputs, h):
    def rate(y):
        return np.array([*y[2:], *accelerations(y[:2], y[2:], outputs)])

    a = rate(y)
    b = rate(y + 0.5 * h * a)
    c = rate(y + 0.5 * h * b)
    return y + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(y + h * c))


@pytest.mark.parametrize(("periods", "exact"), [(None, continuous), (PERIODS, held)])
def test_default_settings(tmp_path, periods, exact):
    t, s, summary = run(tmp_path, case(periods), T_END, STEP, DEFAULT)
    angles = exact(t)
    np.testing.assert_allclose([s["shoulder"], s["elbow"]], angles, atol=1e-5)
    assert summary["warnings"] == []
