"""Forces along coordinates that are narrower than a step: the work that they do is exact.

A body of mass 1 and speed 1 passes a force F(x) and leaves it with v^2 = 1 + 2 W, W the integral
of F over x. A step that is longer than the force is wide does not see it.
"""

from math import asin, cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from samples.coordinate_samples import carriage, force, prepared, run, wheel

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.force_variation import HiddenForces
from plymotion.solver.integrators.generic.base import Integrator
from plymotion.solver.run.preparation import prepare

INTEGRATORS = ("radau", "rk8", "gear", "generalized-alpha")
RTOL = 1e-5  # the default


def by(expression: str) -> str:
    return force("f", "coordinate_force", joint="rail", expression=expression)


def curve(x: list[float], y: list[float]) -> str:
    return force("f", "nonlinear_spring", joint="rail") + (
        f'force_displacement = {{ x = {x}, y = {y}, interpolation = "linear" }}\n'
    )


# Force and its work over the whole way.
FORCES = {
    "comparisons": (by("50 * (x > 1 and x < 1.01)"), 0.5),
    "difference of steps": (by("50 * step(x - 1.3) - 50 * step(x - 1.3004)"), 0.02),
    "peak": (by("100 * exp(-((x - 1.37) / 1e-3)**2)"), 0.1 * sqrt(pi)),
    "beside a wide force": (by("-0.1 * x + 1e3 * max(0, 1e-4 - abs(x - 2))"), None),
    "curve": (curve([-10.0, 1.0, 1.002, 1.004, 10.0], [0.0, 0.0, -200.0, 0.0, 0.0]), 0.4),
    "condition": (by("400 if 0.7 < x and x < 0.701 else 0"), 0.4),
}


def solver(integrator: str, more: str = "") -> str:
    treatment = 'constraints = "ggl"' if integrator == "generalized-alpha" else ""
    return f'integrator = "{integrator}"\n{treatment}\n{more}'


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", FORCES)
def test_work_of_a_narrow_force(tmp_path, name, integrator):
    text, work = FORCES[name]
    _, found, summary = run(tmp_path, carriage(text, speed=1.0), 4.0, 0.5, solver(integrator))
    x, v = found["x"][-1], found["v"][-1]
    expected = sqrt(1.0 + 2.0 * work) if work else sqrt(1.0 + 2.0 * 1e3 * 1e-8 - 0.1 * x**2)
    share = 20 if integrator in ("radau", "rk8") else 200  # the others have low orders behind it
    assert v == pytest.approx(expected, abs=share * RTOL)
    assert not summary["warnings"]


def test_a_narrow_cam_on_a_shaft(tmp_path):
    """Once in each turn a pin passes a spring of 2 mrad; it has done no work behind it."""
    text = wheel(
        force(
            "cam",
            "coordinate_force",
            joint="axle",
            expression="-2000 * sin(x) * exp(-(sin(x / 2) / 1e-3)**2) + 0.5",
        ),
        spin=3.0,
    )
    _, found, summary = run(tmp_path, text, 8.0, 1.0, solver("radau"))
    angle = found["angle"][-1]
    assert angle > 4 * pi  # twice
    potential = 4000.0 * 1e-6 * (1.0 - exp(-((np.sin(angle / 2) / 1e-3) ** 2)))
    expected = sqrt(9.0 + 2.0 / 0.5 * (0.5 * angle - potential))
    assert found["w"][-1] == pytest.approx(expected, rel=20 * RTOL)
    assert summary["cost"]["steps"] < 1500


@pytest.mark.parametrize("integrator", ["radau", "rk8"])
def test_steps_are_taken_again_as_they_were(tmp_path, integrator):
    """Monitors stand after any step of a stride: stops at unseen forces belong to it."""
    text, _ = FORCES["peak"]
    run(tmp_path, carriage(text, speed=1.0), 4.0, 0.5, solver(integrator))
    ready = prepare(load_case(tmp_path / "case.toml").runs["base"], {})
    made = make_integrator(ready.model, ready.y0, ready.mechanism.solver, ready.treatment)
    stopped = False
    while made.status == "running":
        before = made.most_hidden
        made.stride(np.zeros(0), np.zeros((0, made.n)), 0, keep=True)
        steps = made.steps_taken()
        stopped |= made.most_hidden < before
        for i in range(len(steps)):
            np.testing.assert_array_equal(steps.at(i).y, steps.y[i + 1])
        made.take_up()
    assert stopped
    assert made.status == "finished"


@pytest.mark.provokes("breaks-not-searched")
def test_an_end_of_the_look_is_told(tmp_path, monkeypatch):
    """The second force is stepped over; `max_step`, as the message says, sees both."""
    monkeypatch.setattr(Integrator, "most_hidden", 3)  # each peak takes three or four
    peaks = " + ".join(f"100 * exp(-((x - {at}) / 1e-3)**2)" for at in (1.37, 3.2))
    text, gain = carriage(by(peaks), speed=1.0), 0.2 * sqrt(pi)
    _, found, summary = run(tmp_path, text, 4.0, 0.5, solver("radau"))
    assert found["v"][-1] == pytest.approx(sqrt(1.0 + gain), abs=20 * RTOL)
    (told,) = [w for w in summary["warnings"] if w["code"] == "breaks-not-searched"]
    assert told["value"] == told["limit"] == 3
    _, found, summary = run(tmp_path, text, 4.0, 0.5, solver("radau", "max_step = 0.001"))
    assert found["v"][-1] == pytest.approx(sqrt(1.0 + 2.0 * gain), abs=20 * RTOL)
    assert not summary["warnings"]


def test_linear_forces_are_not_looked_at(tmp_path):
    """A spring and damper by an expression take the steps that their stiffness asks for."""
    text = carriage(by("-4 * x - 0.1 * v"), speed=1.0)
    _, _, summary = run(tmp_path, text, 4.0, 0.5, solver("radau"))
    assert summary["cost"]["steps"] < 100
    assert summary["cost"]["rejected"] < 5


@pytest.mark.parametrize("stiff", [1e5, 1e8])
def test_a_body_leaves_a_stiff_brake(tmp_path, stiff):
    """Gear's matrix was that of the brake, and its small first corrections were taken for right."""
    text = carriage(by(f"cos(t) - {stiff} * max(0, v - 1)"), speed=0.5)
    _, found, _ = run(tmp_path, text, 6.0, 0.5, solver("gear", "rtol = 1e-4"))
    assert found["v"][-1] == pytest.approx(sin(6.0), abs=1e-5)  # held from sin(t) = 0.5 to pi / 2


@pytest.mark.parametrize("integrator", ["radau", "rk8", "rk5"])
def test_a_force_at_the_peak_of_a_velocity(tmp_path, integrator):
    """A mass on a spring, braked above a speed that it would hardly pass: held there, then free."""
    edge, w, t_end = 0.999, 5.0, 0.45
    spring = force("spring", "coordinate_force", joint="rail", expression=f"-{w**2} * (x - 0.2)")
    brake = by(f"-1e4 * max(0, v - {edge})")
    _, found, summary = run(tmp_path, carriage(spring, brake), t_end, t_end, solver(integrator))
    held = asin(edge) / w
    middle = held + 0.2 * cos(w * held) / edge  # where the spring pushes no longer
    expected = edge * cos(w * (t_end - middle))
    assert found["v"][-1] == pytest.approx(expected, abs=3 * RTOL)  # free: 76 RTOL more
    assert not summary["warnings"]


@pytest.mark.parametrize("states", [1, 2])
def test_rates_of_states_lie_behind_all_values(tmp_path, states):
    """Those of a single state were read from memory behind the array: runs ended at random."""
    text = "".join(f"[states.s{k}]\nrate = \"-state('s{k}')\"\n" for k in range(states))
    model, y = prepared(tmp_path, carriage(by("max(0, state('s0') - 1)"), text))
    look = HiddenForces(model, (0.0, 1.0), True)
    (watched,) = look._watched
    rates = np.arange(y.size, dtype=float)
    values = look._values(np.zeros(2), np.stack([y, y]), lambda t, y: rates)
    first = model.n_pos + model.n_vel
    assert (values[:, watched.slope] == first).all()
