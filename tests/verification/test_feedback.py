"""Forces that read other coordinates in Newton's matrix: stiff ones take few steps."""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, RADAU, WHEEL, Raw, force, prepared, run
from scipy.linalg import expm

from plymotion.solver.dynamics.evaluation.evaluation import auxiliary_rates_into, evaluate
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.integrators.compiled.pencil import freeze, new_frozen

ALPHA = 'integrator = "generalized-alpha"\nconstraints = "ggl"\nrtol = 1.26e-3'


def two(*forces: str, speeds=(0.0, 0.0)) -> str:
    """Two masses of 1 kg and 2 kg on parallel rails along x."""
    out = ["[ground.O]\nposition = [0.0, 0.0, 0.0]\n[ground.P]\nposition = [0.0, 1.0, 0.0]\n"]
    for k, (point, speed) in enumerate(zip("OP", speeds, strict=True), start=1):
        out.append(
            f'[joints.r{k}]\nkind = "prismatic"\nbetween = ["ground.{point}", "c{k}.a"]\n'
            f"axis = [1.0, 0.0, 0.0]\n"
            f'[signals.x{k}]\nkind = "joint"\njoint = "r{k}"\ncoordinate = "z"\n'
        )
        out.append(
            rigid(f"c{k}", float(k), 0.1, {"a": (0, 0, 0)}, position=(0, k - 1, 0),
                  velocity=(speed, 0, 0))
        )  # fmt: skip
    return "".join(out) + "".join(forces)


def linear(A, y0, t):
    return np.array([expm(A * s) @ y0 for s in t])


@pytest.mark.parametrize("k", [1e4, 1e8, 1e12])
def test_a_stiff_spring_and_damper_by_two_expressions(tmp_path, k):
    """The sum of both coordinates is held: two forces, each of both coordinates and rates.

    The motion is that of one mass of 3 kg, x_1 = -x_2, beside a vibration that is damped at once.
    """
    c = 2.0 * np.sqrt(k)
    law = f"-{k} * (joint('r1') + joint('r2')) - {c} * (joint_rate('r1') + joint_rate('r2'))"
    pull = force("p", "coordinate_force", joint="r1", expression="-12 * x")
    text = two(
        force("a", "coordinate_force", joint="r1", expression=law),
        force("b", "coordinate_force", joint="r2", expression=law),
        pull,
        speeds=(1.0, -1.0),
    )
    t, s, summary = run(tmp_path, text, 3.0, 0.1, DEFAULT)
    np.testing.assert_allclose(s["x1"], np.sin(2 * t) / 2, atol=2e-3 if k < 1e6 else 1e-4)
    np.testing.assert_allclose(s["x2"], -s["x1"], atol=20.0 / k + 1e-8)
    assert summary["cost"]["steps"] + summary["cost"]["rejected"] < 250
    assert summary["checks"]["energy_drift_relative"] < 1e-3


@pytest.mark.parametrize("k", [1e4, 1e8])
def test_the_same_by_generalized_alpha(tmp_path, k):
    """One factorisation a step takes the feedback along: no step is refused."""
    c = 2.0 * np.sqrt(k)
    law = f"-{k} * (joint('r1') + joint('r2')) - {c} * (joint_rate('r1') + joint_rate('r2'))"
    text = two(
        force("a", "coordinate_force", joint="r1", expression=law),
        force("b", "coordinate_force", joint="r2", expression=law),
        force("p", "coordinate_force", joint="r1", expression="-12 * x"),
        speeds=(1.0, -1.0),
    )
    t, s, summary = run(tmp_path, text, 3.0, 0.1, ALPHA)
    np.testing.assert_allclose(s["x1"], np.sin(2 * t) / 2, atol=2e-3)
    np.testing.assert_allclose(s["x2"], -s["x1"], atol=20.0 / k + 1e-6)
    assert summary["cost"]["steps"] < 300
    assert summary["cost"]["rejected"] < 10


def test_a_controller_of_another_body(tmp_path):
    """A force on the first mass holds the second, behind a spring: PD with a filter, stable.

    Against the matrix exponential of the linear equations.
    """
    kp, kd, tf, k, c = 300.0, 60.0, 1e-3, 500.0, 10.0
    spring = f"{k} * (joint('r1') - joint('r2')) + {c} * (joint_rate('r1') - joint_rate('r2'))"
    text = two(
        force("motor", "controller", joint="r1", setpoint="1", sensor="joint('r2')",
              proportional=kp, derivative=kd, filter_time=tf),
        force("one", "coordinate_force", joint="r1", expression=f"-({spring}) - 400 * v"),
        force("two", "coordinate_force", joint="r2", expression=spring),
    )  # fmt: skip
    A = np.zeros((6, 6))  # x1 x2 v1 v2 w 1
    A[0, 2] = A[1, 3] = 1.0
    A[2] = [-k, k - kp - kd / tf, -c - 400, c, -kd / tf, kp + kd / tf]
    A[3] = [k / 2, -k / 2, c / 2, -c / 2, 0, 0]
    A[4] = [0, -1 / tf, 0, 0, -1 / tf, 1 / tf]
    t, s, _ = run(tmp_path, text, 2.0, 0.1, RADAU)
    y = linear(A, np.array([0, 0, 0, 0, 1.0, 1.0]), t)
    np.testing.assert_allclose(s["x1"], y[:, 0], atol=1e-5)
    np.testing.assert_allclose(s["x2"], y[:, 1], atol=1e-5)


def test_slopes_against_differences(tmp_path):
    """Slopes of forces, states and reactions by what they read, as the matrix takes them."""
    text = (
        "gravity = [3.0, -9.81, 1.0]\n"
        + two(
            force("a", "coordinate_force", joint="r1",
                  expression="-3 * x * joint('r2') - sin(joint_rate('r2')) * v"),
            force("b", "controller", joint="r2", setpoint="joint('r1')**2", proportional=5.0,
                  derivative=3.0, filter_time=0.1),
            force("f", "friction", joint="r1", coefficient=0.3, length=0.2, rest_velocity=0.9),
            speeds=(0.7, 0.4),
        )
    )  # fmt: skip
    model, y = prepared(tmp_path, text)
    y, t, first = y.copy(), 0.3, model.n_pos + model.n_vel
    y[0], y[7] = 0.25, -0.4
    rng = np.random.default_rng(1)
    multipliers = rng.normal(size=model.n_constraint)
    y[first : first + model.n_aux] = 0.3
    work, frozen = new_workspace(model), new_frozen(model)

    def found(state, mu):
        out = np.zeros(y.size)
        work.multipliers[:] = mu
        evaluate(model, work, t, state)
        auxiliary_rates_into(model, work, t, out)
        return np.concatenate([-work.size[:, 0], out[first : first + model.n_aux]])

    def slope(k, of_mu):
        h = 1e-6
        d = np.zeros(model.n_constraint if of_mu else y.size)
        d[k] = h
        plus, minus = ((found(y, multipliers + s * d) if of_mu else found(y + s * d, multipliers))
                       for s in (1, -1))  # fmt: skip
        return (plus - minus) / (2 * h)

    q = model.quantities
    assert q.feedback.tolist() == [0, 1, 2]
    found(y, multipliers)
    freeze(model, work, t, y, frozen)
    fed, by_mu = frozen.feedback.fed, frozen.feedback.by_reactions
    np.testing.assert_allclose(fed[0, 0, 1, 0], slope(7, False)[0], rtol=1e-6)
    np.testing.assert_allclose(fed[0, 1, 1, 0], slope(model.n_pos + 6, False)[0], rtol=1e-6)
    np.testing.assert_allclose(fed[1, 0, 0, 0], slope(0, False)[1], rtol=1e-6)
    j = int(np.flatnonzero(q.coupled_state == 1)[0])  # the filter of the controller
    np.testing.assert_allclose(fed[3 + j, 0, 0, 0], slope(0, False)[3 + 1], rtol=1e-6)
    for row in range(model.n_constraint):
        np.testing.assert_allclose(by_mu[2, row], slope(row, True)[2], rtol=1e-6, atol=1e-9)
    assert np.abs(by_mu[2]).max() > 0.01
    assert not fed[0, :, 0].any()  # its own coordinate is a row of its own
    assert not fed[2].any()


def load(name: str, kind: str, at: str, direction: list[float], law: str, **keys) -> str:
    """A load by an expression."""
    law = Raw(f"{{ expression = '{law}' }}")
    return force(name, kind, at=at, direction=Raw(direction), law=law, **keys)


def bearings(k: float, c: float, *, by_loads: bool) -> str:
    """A rotor that spins at 500 rad/s and moves across its axis, in two bearings."""
    out = []
    for at, x in (("a", 0.5), ("b", -0.5)):
        out.append(f"[ground.{at}]\nposition = [{x}, 0.0, 0.0]\n")
        if not by_loads:
            ends = Raw(f'["ground.{at}", "rotor.{at}"]')
            hold = {"stiffness": Raw([0.0, k, k]), "damping": Raw([0.0, c, c])}
            out.append(force(at, "bushing", between=ends, **hold))
        for axis, direction in (("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])) * by_loads:
            of = f'("rotor.{at}", "{axis}")'
            law = f"-{k} * position{of} - {c} * velocity{of}"
            out.append(load(at + axis, "force", f"rotor.{at}", direction, law))
    points = {"a": (0.5, 0, 0), "b": (-0.5, 0, 0)}
    speeds = {"velocity": (0, 0.2, 0), "angular_velocity": (500, 0, 0.1)}
    y = '[signals.y]\nkind = "position"\nat = "rotor.a"\ncomponent = "y"\n'
    return rigid("rotor", 8.0, (0.04, 0.4, 0.4), points, **speeds) + "".join(out) + y


@pytest.mark.parametrize("solver", [DEFAULT, ALPHA], ids=["radau", "generalized-alpha"])
def test_loads_by_position_and_velocity_take_the_steps_of_bushings(tmp_path, solver):
    """Bearings of a rotor by four loads: its motion and steps are those with bushings."""
    cost, y = [], []
    for by_loads in (False, True):
        text = bearings(1e8, 1e5, by_loads=by_loads)
        _, s, summary = run(tmp_path, text, 0.05, 0.001, solver)
        cost.append(summary["cost"]["steps"] + summary["cost"]["rejected"])
        y.append(s["y"])
    np.testing.assert_allclose(y[1], y[0], atol=1e-6)
    assert cost[1] < 1.5 * cost[0]


@pytest.mark.parametrize(("kind", "frame"), [("force", "following"), ("torque", "global")])
def test_loads_of_both_frames_by_the_speed_of_a_joint(tmp_path, kind, frame):
    """A load brakes a wheel to 3 rad/s at a rate of 2e6 / s, and takes as few steps as that is."""
    direction = [0.0, 1.0, 0.0] if kind == "force" else [0.0, 0.0, 1.0]
    brake = load("brake", kind, "wheel.rim", direction, "-1e6 * (joint_rate(\"axle\") - 3)",
                 frame=frame)  # fmt: skip
    text = WHEEL + brake
    text += rigid("wheel", 2.0, 0.5, {"a": (0, 0, 0), "rim": (1, 0, 0)})
    t, s, summary = run(tmp_path, text, 2.0, 0.1, DEFAULT)
    np.testing.assert_allclose(s["w"][1:], 3.0, atol=1e-5)
    np.testing.assert_allclose(s["angle"][1:], 3.0 * t[1:], atol=1e-4)
    assert summary["cost"]["steps"] + summary["cost"]["rejected"] < 100
