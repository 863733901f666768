"""Controllers against closed forms: continuous, saturated, sampled."""

import itertools

import numpy as np
import pytest
from samples.case_samples import case_runs, rigid
from samples.coordinate_samples import DEFAULT, RADAU, WHEEL, carriage, force, run, wheel
from scipy.integrate import solve_ivp

from plymotion.solver.dynamics.evaluation.accelerations import sample_into
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.integrators import explicit
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.compiled.explicit_loop import advance_explicit
from plymotion.solver.math.compiled import rebound
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.preparation import prepare


def controller(joint="rail", **keys):
    return force("c", "controller", **{"joint": joint, "setpoint": "0.1", **keys})


@pytest.mark.parametrize("solver", ["", RADAU])
def test_proportional_and_derivative(tmp_path, solver):
    """Without a filter, through gears: m x'' = n (kp (x0 - x) - kd x'), and a moving setpoint."""
    text = carriage(
        controller(setpoint="0.1 + 0.2 * t", proportional=20.0, derivative=2.0, gear_ratio=2.0),
        mass=2.0,
    )
    t, s, summary = run(tmp_path, text, 2.0, 0.05, solver)
    w, d = np.sqrt(20.0), 1.0
    r = np.sqrt(w**2 - d**2)
    # error e = setpoint - x: e(0) = 0.1, edot(0) = 0.2
    e = np.exp(-d * t) * (0.1 * np.cos(r * t) + (0.2 + d * 0.1) / r * np.sin(r * t))
    np.testing.assert_allclose(s["x"], 0.1 + 0.2 * t - e, atol=1e-8)
    assert summary["checks"]["energy_drift_relative"] < 1e-6


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
def test_integral_filter_and_saturation(tmp_path, solver):
    """Of a wheel turned by more than a turn, against the equations integrated elsewhere."""
    keys = {"proportional": 8.0, "integral": 6.0, "derivative": 2.0, "filter_time": 0.02}
    text = wheel(
        controller("axle", setpoint="9.0", upper=5.0, lower=-4.0, feedforward="0.5 * sin(t)",
                   **keys),
        inertia=0.5,
    )  # fmt: skip
    t, s, summary = run(tmp_path, text, 6.0, 0.1, solver)

    def rates(t, y):
        x, v, integral, w = y
        demand = 8.0 * (9.0 - x) + integral + 2.0 * (9.0 - x - w) / 0.02 + 0.5 * np.sin(t)
        output = np.clip(demand, -4.0, 5.0)
        back = (output - demand) * 6.0 / 8.0
        return [v, output / 0.5, 6.0 * (9.0 - x) + back, (9.0 - x - w) / 0.02]

    exact = solve_ivp(rates, (0, 6), [0, 0, 0, 9.0], "DOP853", t, rtol=1e-11, atol=1e-12)
    assert np.ptp(np.clip(exact.y[1], None, None)) > 10.0
    loose = {"": 1e-6, RADAU: 1e-5, DEFAULT: 2e-2}[solver]
    np.testing.assert_allclose(s["angle"], exact.y[0], atol=loose)
    assert summary["cost"]["steps"] < (3000 if not solver else 1500)


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
def test_sampled(tmp_path, solver):
    """The output is held between instants: exact recursion of a mass under constant forces."""
    period, kp, ki, kd, tf, m = 0.01, 40.0, 30.0, 4.0, 0.02, 2.0
    text = carriage(
        controller(setpoint="0.1 * cos(t)", sensor="joint('rail')", proportional=kp, integral=ki,
                   derivative=kd, filter_time=tf, sample_time=period, upper=3.0),
        mass=m,
    )  # fmt: skip
    _t, s, summary = run(tmp_path, text, 1.0, 0.1, solver)
    x = v = integral = 0.0
    found, w = [0.0], 0.1
    for k in range(100):
        error = 0.1 * np.cos(k * period) - x
        demand = kp * error + integral + kd * (error - w) / (tf + period)
        output = min(demand, 3.0)
        integral += period * (ki * error + (output - demand) * ki / kp)
        w = (tf * w + period * error) / (tf + period)
        x, v = x + period * v + 0.5 * period**2 * output / m, v + period * output / m
        if k % 10 == 9:
            found.append(x)
    np.testing.assert_allclose(s["x"], found, rtol=1e-9, atol=1e-12)
    assert summary["cost"]["steps"] <= 130
    if solver == RADAU:  # five of each step, eight if it forgot at each sample what was before
        assert summary["cost"]["evaluations"] <= 6 * 100
    assert summary["checks"]["energy_drift_relative"] < 1e-10


def test_two_rates(tmp_path):
    """Controllers of 3 ms and 7 ms: exact recursion from instant to instant."""
    text = carriage(
        force("a", "controller", joint="rail", setpoint="1", proportional=3.0, sample_time=3e-3),
        force("b", "controller", joint="rail", setpoint="0", sensor="v", proportional=2.0,
              sample_time=7e-3),
    )  # fmt: skip
    # The motion between instants is exact at any tolerance: each step may end at the next instant.
    solver = 'integrator = "rk8"\nrtol = 1e-9\natol_position = 1e-11\natol_velocity = 1e-11'
    _, s, summary = run(tmp_path, text, 0.1, 0.1, solver)
    x = v = f_a = f_b = 0.0
    instants = sorted({*range(0, 100, 3), *range(0, 100, 7), 100})
    for begin, end in itertools.pairwise(instants):
        f_a = 3.0 * (1 - x) if begin % 3 == 0 else f_a
        f_b = -2.0 * v if begin % 7 == 0 else f_b
        h = 1e-3 * (end - begin)
        x, v = x + h * v + 0.5 * h * h * (f_a + f_b), v + h * (f_a + f_b)
    assert s["x"][-1] == pytest.approx(x, rel=1e-10)
    assert summary["cost"]["steps"] <= len(instants) + 10


@pytest.mark.parametrize("integrator", ["radau", "rk8"])
def test_the_loop_samples_by_itself(tmp_path, integrator):
    """Many instants in one call, and monitors stand after any step, with the outputs there."""
    text = carriage(controller(setpoint="sin(t)", proportional=9.0, derivative=2.0,
                               filter_time=0.01, sample_time=0.01))  # fmt: skip
    run(tmp_path, text, 2.0, 1.0, f'integrator = "{integrator}"')
    ready = prepare(load_case(tmp_path / "case.toml").runs["base"], {})
    made = make_integrator(ready.model, ready.y0, ready.mechanism.solver, ready.treatment)
    calls = 0
    while made.status == "running":
        made.stride(np.zeros(0), np.zeros((0, made.n)), 0, keep=True)
        steps, calls = made.steps_taken(), calls + 1
        for i in range(0, len(steps), 7):
            here = steps.at(i)
            np.testing.assert_array_equal(here.y, steps.y[i + 1])
            # 0 at instants before, so that monitors that look into a step saw NaN
            assert here.h == pytest.approx(steps.t[i + 1] - steps.t[i], rel=1e-9)
            assert np.isfinite(here.dense_output()(steps.t[i] + 0.5 * here.h)).all()
        made.take_up()
    assert made.counters.steps >= 199
    assert calls <= 4  # 200 steps in each, and one more before the last


@pytest.mark.parametrize("integrator", ["rk5", "rk8"])
def test_a_sample_goes_on_from_the_evaluation_of_its_step(tmp_path, monkeypatch, integrator):
    """Unless outputs inside of the step came between; the motion of a pendulum is the same."""
    known = []

    def sample(*arguments):
        known.append(arguments[-1])
        sample_into(*arguments)

    monkeypatch.setattr(explicit, "advance_explicit", rebound(advance_explicit, sample_into=sample))
    text = WHEEL + rigid("wheel", 2.0, 0.5, {"a": (0.3, 0.1, 0.2)})
    text += controller("axle", setpoint="1", proportional=9.0, derivative=1.0, sample_time=0.02)
    _, expected, _ = run(tmp_path, text, 0.2, 0.2, f'integrator = "{integrator}"')
    assert set(known) == {True}
    known.clear()
    _, found, _ = run(tmp_path, text, 0.2, 0.025, f'integrator = "{integrator}"')
    assert known.count(False) == 6
    for name in ("angle", "w"):
        np.testing.assert_allclose(found[name][-1], expected[name][-1], rtol=1e-12)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({}, "has no effect; expected proportional, integral or derivative"),
        ({"proportional": 1.0, "upper": 1.0, "lower": 2.0}, "forces.c.lower = 2: expected below"),
        ({"proportional": 1.0, "anti_windup_time": 1.0}, "expected lower or upper"),
        ({"proportional": 1.0, "sample_time": 0.0}, "forces.c.sample_time = 0.0: value should"),
        ({"proportional": 1.0, "setpont": "1"}, "did you mean 'setpoint'"),
        ({"proportional": 1.0, "sensor": "joint('rail"}, "expected an expression"),
        ({"derivative": 1.0, "sensor": "v"}, "has a rate by time that is not known"),
    ],
)
def test_bad_input(tmp_path, keys, words):
    with pytest.raises(InputError) as caught:
        run(tmp_path, carriage(controller(**keys)), 0.1, 0.1)
    assert words in str(caught.value)


def test_integrators_that_do_not_stop_at_instants_say_so(tmp_path):
    text = carriage(controller(proportional=1.0, sample_time=0.01))
    with pytest.raises(InputError, match=r"gear.*sample_time; expected radau or rk8 or rk5"):
        run(tmp_path, text, 0.1, 0.1, 'integrator = "gear"')


@pytest.mark.parametrize("sample", ["carriage", "wheel"])
def test_at_rest_in_equilibrium(tmp_path, sample):
    """Nothing moves, and round-off is no error of the energy balance."""
    made, joint = {"carriage": (carriage, "rail"), "wheel": (wheel, "axle")}[sample]
    text = made(controller(joint, setpoint="0.3", proportional=50.0, derivative=5.0))
    _, s, summary = run(tmp_path, text, 1.0, 0.5, DEFAULT + '\nstart = "equilibrium"')
    name = "x" if sample == "carriage" else "angle"
    np.testing.assert_allclose(s[name], 0.3, atol=1e-9)
    assert summary["warnings"] == []


def test_a_stiff_controller_within_one_output_step(tmp_path):
    """10 N / um: over in 2 ms of the steps, by the row of Newton's matrix in few of them."""
    text = carriage(controller(setpoint="0.01", proportional=1e7, derivative=1e4), mass=2.0)
    _, s, summary = run(tmp_path, text, 1.0, 0.5, DEFAULT)
    np.testing.assert_allclose(s["x"][1:], 0.01, rtol=1e-6)
    assert summary["cost"]["steps"] < 200
    assert summary["warnings"] == []


def test_an_unstable_sampled_loop_is_told(repository, tmp_path):
    """An arm with gains 1000 times as high: stable with 0.5 ms; with 2 ms the links fail."""
    runs = case_runs(repository, "controlled-arm", tmp_path)
    changes = {"solver.t_end": 0.25, "solver.output_step": 0.01}
    for motor, kp, kd, ki in (("motor_1", 12.0, 0.0822, 20.0), ("motor_2", 6.0, 0.0253, 10.0)):
        gains = {"proportional": kp, "derivative": kd, "integral": ki, "lower": None, "upper": None}
        changes |= {f"forces.{motor}.{key}": value for key, value in gains.items()}
    found = {}
    for period in (5e-4, 2e-3):
        times = {f"forces.motor_{k}.sample_time": period for k in (1, 2)}
        _, summary = execute(read_run(runs / "free.json").changed(changes | times), progress=False)
        found[period] = {w["code"]: w["message"] for w in summary["warnings"]}
        assert summary["completed"] == (period < 1e-3)
    assert found[5e-4] == {}
    assert "its loop may be unstable" in found[2e-3]["spin-above-clamped-frequency"]
