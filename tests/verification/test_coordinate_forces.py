"""Forces along coordinates against closed forms: expressions, curves, stops, friction."""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import (
    CARRIAGE,
    DEFAULT,
    RADAU,
    Raw,
    carriage,
    force,
    prepared,
    run,
    wheel,
)
from scipy.integrate import solve_ivp
from scipy.special import gamma

from plymotion.solver.dynamics.evaluation.evaluation import auxiliary_rates_into, evaluate
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.errors import InputError
from plymotion.solver.integrators.compiled.pencil import freeze, new_frozen


@pytest.mark.parametrize("solver", ["", RADAU])
def test_expression_of_coordinate_and_rate(tmp_path, solver):
    """A damped oscillator under a load of time: x'' + 2 d x' + w^2 x = sin(3 t)."""
    text = "[parameters]\nw = 5.0\nd = 0.4\n" + carriage(
        force("all", "coordinate_force", joint="rail",
              expression="2 * (sin(3 * t) - 2 * d * joint_rate('rail') - w**2 * x)"),
        mass=2.0,
    )  # fmt: skip
    t, s, summary = run(tmp_path, text, 2.0, 0.05, solver)
    w, d, p = 5.0, 0.4, 3.0
    a, b = np.linalg.solve([[w**2 - p**2, -2 * d * p], [2 * d * p, w**2 - p**2]], [1.0, 0.0])
    r = np.sqrt(w**2 - d**2)
    free = np.exp(-d * t) * (-b * np.cos(r * t) + (-a * p - d * b) / r * np.sin(r * t))
    np.testing.assert_allclose(s["x"], a * np.sin(p * t) + b * np.cos(p * t) + free, atol=2e-8)
    assert summary["checks"]["energy_drift_relative"] < 1e-6


@pytest.mark.parametrize(("size", "mass"), [(1.0, 1.0), (4e-4, 1e-5)])
def test_accuracy_does_not_depend_on_the_size(tmp_path, size, mass):
    """A body whose only extent is its inertia counted as 1 m: the small one had 55 rtol."""
    law = f"-{50.0 * mass} * x * (1 + 0.15 * (x / {size})**2)"
    body = CARRIAGE + rigid(
        "car", mass, 0.01 * mass * size**2, {"a": (0, 0, 0)}, velocity=(6.5 * size, 0, 0)
    )
    spring = force("spring", "coordinate_force", joint="rail", expression=law)
    t, s, _ = run(tmp_path, body + spring, 7.0, 0.7, DEFAULT)
    exact = solve_ivp(
        lambda _, z: [z[1], -50.0 * z[0] * (1 + 0.15 * z[0] ** 2)],
        (0.0, 7.0),
        [0.0, 6.5],
        "DOP853",
        t,
        rtol=1e-12,
        atol=1e-12,
    )
    np.testing.assert_allclose(s["x"] / size, exact.y[0], rtol=0.0, atol=2e-5)


def test_angles_over_many_turns(tmp_path):
    """A spring of a hinge wound up by 4.5 turns and back: no jump half a turn away."""
    text = wheel(force("coil", "coordinate_force", joint="axle", expression="-2 * x"), spin=56.5)
    t, s, summary = run(tmp_path, text, 4.0, 0.02)
    np.testing.assert_allclose(s["angle"], 56.5 / 2.0 * np.sin(2.0 * t), atol=1e-8)
    assert np.abs(s["angle"]).max() > 4.4 * 2 * np.pi
    assert summary["checks"]["energy_drift_relative"] < 1e-10


def test_loads_and_actuators_by_expressions(tmp_path):
    """A load that reads a place, an actuator that reads a distance: as by springs."""
    bodies = carriage(speed=1.0)
    load = (
        '[forces.f]\nkind = "force"\nat = "car.a"\ndirection = [1, 0, 0]\n'
        'law = { expression = "%s" }\n'
    )
    spring = "[ground.far]\nposition = [-3.0, 0.0, 0.0]\n" + (
        '[forces.s]\nkind = "spring"\nbetween = ["ground.far", "car.a"]\n'
        "actuator = { expression = \"-9 * (distance('ground.far', 'car.a') - 3) "
        "- distance_rate('ground.far', 'car.a')\" }\n"
    )
    t, one, _ = run(tmp_path, bodies + load % "-9 * position('car.a', 'x') - signal('v')", 2.0, 0.1)
    t, two, _ = run(tmp_path, bodies + spring, 2.0, 0.1)
    r = np.sqrt(9 - 0.25)
    for found in (one, two):
        np.testing.assert_allclose(found["x"], np.exp(-0.5 * t) * np.sin(r * t) / r, atol=1e-9)


def test_drive_by_expression(tmp_path):
    """A hinge driven by an expression: angle, and the torque by its second derivative."""
    text = wheel(inertia=0.5).replace(
        'kind = "revolute"', 'kind = "revolute"\ndrive = { expression = "a * sin(3 * t)**2" }'
    ) + (
        "[parameters]\na = 4.0\n"
        '[signals.M]\nkind = "reaction"\njoint = "axle"\nquantity = "moment"\ncomponent = "z"\n'
    )
    t, s, _ = run(tmp_path, text, 1.0, 0.05)
    np.testing.assert_allclose(s["angle"], 4.0 * np.sin(3 * t) ** 2, atol=1e-9)
    np.testing.assert_allclose(s["M"], 0.5 * 72.0 * np.cos(6 * t), atol=1e-7)


@pytest.mark.parametrize("between", [False, True])
def test_linear_curves_are_spring_and_damper(tmp_path, between):
    on = {"joint": "rail"}
    if between:
        on = {"between": Raw('["ground.far", "car.a"]'), "length": 3.0}
    text = "[ground.far]\nposition = [-3.0, 0.0, 0.0]\n" + carriage(
        force(
            "s",
            "nonlinear_spring",
            **on,
            force_displacement=Raw("{ x = [-0.1, 0.0, 0.2], y = [-0.9, 0.0, 1.8] }"),
            force_velocity=Raw('{ x = [0, 1], y = [0, 1], interpolation = "linear" }'),
        ),
        speed=1.0,
    )
    t, s, _ = run(tmp_path, text, 2.0, 0.1)
    r = np.sqrt(9 - 0.25)
    np.testing.assert_allclose(s["x"], np.exp(-0.5 * t) * np.sin(r * t) / r, atol=1e-9)


def test_a_curve_of_the_third_degree(tmp_path):
    """-k x^3 by many points: the quarter period K(1/2) / sqrt(k / m) from rest at 1 m."""
    x = np.linspace(-2.2, 0.2, 241)
    curve = f"{{ x = {x.tolist()}, y = {(50.0 * (x + 1.0) ** 3).tolist()} }}"
    # the coordinate is 0 at the start, 1 m off the middle
    text = carriage(
        force("s", "nonlinear_spring", joint="rail", force_displacement=Raw(curve)), mass=2.0
    )
    quarter = gamma(0.25) ** 2 / (4.0 * np.sqrt(np.pi)) / 5.0
    _, s, _ = run(tmp_path, text, quarter, quarter / 4)
    assert s["x"][-1] == pytest.approx(-1.0, abs=1e-5)


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
@pytest.mark.parametrize(("restitution", "exponent"), [(1.0, 1.5), (0.8, 1.5), (0.3, 1.0)])
def test_a_mass_leaves_a_stop_with_the_restitution(tmp_path, restitution, exponent, solver):
    """Without other forces: e times the speed at `impact_speed`, by steps of any size before."""
    text = carriage(
        force("stop", "limit_stop", joint="rail", upper=1.0, stiffness=1e7, exponent=exponent,
              restitution=restitution, impact_speed=2.0),
        speed=2.0,
    )  # fmt: skip
    _, s, summary = run(tmp_path, text, 2.0, 0.5, solver)
    loose = 1e-3 if solver == DEFAULT else 1e-6
    assert s["v"][-1] == pytest.approx(-2.0 * restitution, rel=loose)
    assert summary["checks"]["energy_drift_relative"] < loose
    assert not [w for w in summary["warnings"] if "energy" in w["code"]]
    assert summary["cost"]["steps"] < 3000


def test_a_slower_impact_loses_less(tmp_path):
    """At half the speed: a = b u / 2 in a (1 + e) = log((1 + a) / (1 - a e))."""
    text = carriage(
        force("stop", "limit_stop", joint="rail", lower=-0.5, stiffness=1e6, restitution=0.5,
              impact_speed=2.0),
        speed=-1.0,
    )  # fmt: skip
    _, s, _ = run(tmp_path, text, 1.5, 0.5)
    e = s["v"][-1]
    a = 0.5 * 1.4327505332713764  # half of that of e = 0.5
    assert 0.5 < e < 1.0
    assert a * (1 + e) == pytest.approx(np.log((1 + a) / (1 - a * e)), rel=1e-6)


def test_a_bouncing_mass(tmp_path):
    """Falls of a hard ball without loss: tops of the same height, 2 sqrt(2 h / g) apart."""
    text = carriage(
        force("floor", "limit_stop", joint="rail", lower=-1.0, stiffness=1e10, restitution=1.0),
        force("weight", "coordinate_force", joint="rail", expression="-9.81"),
    )
    period = 2.0 * np.sqrt(2.0 / 9.81)
    _, s, summary = run(tmp_path, text, 4 * period, period / 200, DEFAULT)
    tops = s["x"][[200, 400, 600, 800]]
    # the contact lasts 3.2 (m^2 / (K^2 u))^(1/5) [Hertz]: 0.24 ms, and tops are round
    assert np.abs(tops).max() < 2e-3
    assert summary["cost"]["steps"] < 1500
    assert summary["checks"]["energy_drift_relative"] < 1e-3


def test_friction_stops_a_mass(tmp_path):
    """Coulomb: v = u - F t / m up to u m / F, then at rest, against a smaller load."""
    text = carriage(
        force("f", "friction", joint="rail", coulomb=3.0, rest_velocity=1e-5),
        force("p", "coordinate_force", joint="rail", expression="1 if t > 1 else 0"),
        mass=2.0, speed=1.2,
    )  # fmt: skip
    t, s, summary = run(tmp_path, text, 2.0, 0.1, RADAU)
    stop = 1.2 * 2.0 / 3.0
    way = np.where(t < stop, 1.2 * t - 0.75 * t**2, 0.6 * stop)
    np.testing.assert_allclose(s["x"], way, atol=3e-5)
    assert abs(s["v"][-1]) < 1e-5  # creeps at atanh(1/3) of the rest velocity
    assert summary["checks"]["drive_work"] == pytest.approx(-0.5 * 2.0 * 1.2**2, rel=1e-4)


def stick_slip(kind, **keys):
    """A mass of 1 kg on a spring of 2 N/m whose other end moves at 0.1 m/s."""
    return carriage(
        force("f", kind, joint="rail", coulomb=1.0, static=1.5, stribeck_velocity=1e-3, **keys),
        force("s", "coordinate_force", joint="rail", expression="-2 * (x - 0.1 * t)"),
    )


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("friction", {"rest_velocity": 1e-4}),
        ("bristle_friction", {"bristle_stiffness": 1e5, "bristle_damping": 300.0}),
    ],
)
def test_stick_and_slip(tmp_path, kind, keys):
    """Period of the closed form: 2 (Fs - Fc) / (k v) at rest and a part of a swing sliding.

    Regularised friction has its largest value below Fs. The bristle gives way a little earlier, the
    more the faster the force grows.
    """
    t, s, summary = run(tmp_path, stick_slip(kind, **keys), 40.0, 0.005, RADAU)
    k, v, w = 2.0, 0.1, np.sqrt(2.0)
    u = np.linspace(0.0, 0.01, 10001)
    largest = (1.0 + 0.5 * np.exp(-((u / 1e-3) ** 2))) * np.tanh(u / 1e-4)
    drop = ((largest.max() if kind == "friction" else 1.5) - 1.0) / k
    sliding = (2 * np.pi - 2 * np.arctan(drop * w / v)) / w
    period = 2 * drop / v + sliding
    moving = s["v"] > 0.02
    begins = t[1:][moving[1:] & ~moving[:-1]]
    assert len(begins) >= 4
    np.testing.assert_allclose(np.diff(begins[1:]), period, rtol=0.02)
    top = np.sqrt((drop * w) ** 2 + v**2) + v
    assert s["v"].max() == pytest.approx(top, rel=0.02)
    assert summary["checks"]["energy_drift_relative"] < 1e-3


def test_stick_and_slip_with_default_settings(tmp_path):
    fine = run(tmp_path, stick_slip("friction", rest_velocity=1e-4), 20.0, 0.05, RADAU)[1]
    _, found, summary = run(
        tmp_path, stick_slip("friction", rest_velocity=1e-4), 20.0, 0.05, DEFAULT
    )
    assert np.abs(found["x"] - fine["x"]).max() < 5e-3
    assert summary["warnings"] == []


def test_steep_friction_refuses_few_steps(tmp_path):
    """At a rest velocity of 1e-8 of the motion's: each step towards the corner of the law began
    with a length at which the last one had nearly failed.
    """
    steep = stick_slip("friction", rest_velocity=1e-9)
    cost = run(tmp_path, steep, 20.0, 0.05, DEFAULT)[2]["cost"]
    assert cost["rejected"] < 0.2 * (cost["rejected"] + cost["steps"])


@pytest.mark.provokes("steps-refused")
def test_friction_too_steep_for_the_tolerance_is_told(tmp_path):
    """Newton's iteration does not find the corner of a law narrower than the tolerance."""
    law = force("f", "friction", joint="rail", coulomb=2.0, rest_velocity=1e-6)
    solver = 'integrator = "generalized-alpha"\nconstraints = "ggl"\nrtol = 5e-4'
    summary = run(tmp_path, carriage(law, speed=1.0), 3.0, 0.1, solver)[2]
    (finding,) = [w for w in summary["warnings"] if w["code"] == "steps-refused"]
    assert "for forces.f a larger rest_velocity" in finding["message"]


def test_steady_sliding_of_the_bristle(tmp_path):
    """At a constant speed its friction is Fc + (Fs - Fc) exp(-(v / vs)^2) + s2 v."""
    text = carriage(
        force("f", "bristle_friction", joint="rail", coulomb=1.0, static=1.5, viscous=0.4,
              stribeck_velocity=0.05, bristle_stiffness=1e4, bristle_damping=100.0),
        speed=0.03,
    ).replace('axis = [1.0, 0.0, 0.0]', 'axis = [1.0, 0.0, 0.0]\ndrive = { speed = 0.03 }') + (
        '[signals.F]\nkind = "reaction"\njoint = "rail"\nquantity = "force"\ncomponent = "x"\n'
    )  # fmt: skip
    _, s, _ = run(tmp_path, text, 0.1, 0.05)
    assert s["F"][-1] == pytest.approx(1.0 + 0.5 * np.exp(-0.36) + 0.012, rel=1e-8)


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("coordinate_force", {"expression": "-3 * x**3 - 2 * v * abs(v) + sin(t)"}),
        ("nonlinear_spring", {"force_displacement": Raw("{ x = [-1, 0, 1], y = [-3, 0, 5] }")}),
        ("limit_stop", {"upper": 0.1, "stiffness": 1e3, "restitution": 0.5, "impact_speed": 2.0}),
        ("friction", {"coulomb": 2.0, "rest_velocity": 0.9, "viscous": 0.1}),
        ("bristle_friction", {"coulomb": 1.0, "bristle_stiffness": 1e2, "viscous": 3.0}),
        ("controller", {"setpoint": "x**2", "sensor": "2 * x", "proportional": 5.0,
                        "integral": 7.0, "derivative": 3.0, "filter_time": 0.1}),
    ],
)  # fmt: skip
def test_newtons_matrix_against_differences(tmp_path, kind, keys):
    """Slopes of the force by coordinate, rate and its states, and of the states' rates."""
    text = carriage(force("f", kind, **{"joint": "rail", **keys}), speed=0.7)
    model, y = prepared(tmp_path, text)
    y, t, first = y.copy(), 0.3, model.n_pos + model.n_vel
    y[0] = 0.25
    y[first : first + model.n_aux] = 0.004 + 0.001 * np.arange(model.n_aux)
    work, frozen = new_workspace(model), new_frozen(model)

    def force_and_rates(k, h):
        near, out = y.copy(), np.zeros(y.size)
        near[k] += h
        evaluate(model, work, t, near)
        auxiliary_rates_into(model, work, t, out)
        return np.append(work.size[0, 0], out[first : first + model.n_aux])

    def slope(k):
        h = 1e-6
        return (force_and_rates(k, h) - force_and_rates(k, -h)) / (2 * h)

    evaluate(model, work, t, y)
    freeze(model, work, t, y, frozen)
    assert frozen.stiffness.size == 1
    by_x, by_v = slope(0), slope(model.n_pos)
    assert -frozen.stiffness[0] == pytest.approx(min(by_x[0], 0.0), rel=1e-6, abs=1e-8)
    assert -frozen.damping[0] == pytest.approx(min(by_v[0], 0.0), rel=1e-6, abs=1e-8)
    q = model.quantities
    assert q.coupled_state.tolist() == list(range(model.n_aux))
    for p, j in enumerate(q.coupled_state):
        by_z = slope(first + j)
        found = [-by_z[0], by_x[1 + j], by_v[1 + j]]
        np.testing.assert_allclose(frozen.feedback.coupled[p], found, rtol=1e-6, atol=1e-7)
        assert frozen.feedback.auxiliary[j] == pytest.approx(by_z[1 + j], rel=1e-6, abs=1e-7)
    one, two = model.force_marker[0]
    g = work.g[q.along[0]]
    found = g[6:9] @ work.J_m[two, :3, :6] + g[9:] @ work.J_m[two, 3:, :6]
    np.testing.assert_allclose(found, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-15)
    assert model.marker_body[one] == -1


def test_states_in_newtons_matrix_spare_steps(tmp_path):
    """A bristle of 1e5 N/m: with its row the iteration converges by the steps of the accuracy."""
    keys = {"bristle_stiffness": 1e5, "bristle_damping": 300.0}
    _, _, summary = run(tmp_path, stick_slip("bristle_friction", **keys), 20.0, 0.1, DEFAULT)
    assert summary["cost"]["steps"] + summary["cost"]["rejected"] < 600


KINDS = {
    "coordinate_force": {"expression": "-x"},
    "limit_stop": {"upper": 1.0, "stiffness": 1e3},
    "friction": {"coulomb": 1.0, "rest_velocity": 0.1},
    "bristle_friction": {"coulomb": 1.0, "bristle_stiffness": 1e3},
}


@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        ("limit_stop", {"upper": None}, "has no effect; expected lower or upper"),
        ("limit_stop", {"lower": 2.0}, "forces.f.lower = 2: expected below upper = 1"),
        ("limit_stop", {"impact_speed": 0.0}, "forces.f.impact_speed = 0.0: value should be"),
        ("limit_stop", {"restitution": 1.5}, "forces.f.restitution = 1.5: value should be less"),
        ("limit_stop", {"stiffness": -1.0}, "forces.f.stiffness = -1.0: value should be greater"),
        ("limit_stop", {"joint": "rial"}, "forces.f.joint: there is no joint rial; did you mean"),
        ("limit_stop", {"coordinate": "angle"}, 'is prismatic, not "angle"; expected one of z'),
        ("limit_stop", {"joint": None}, "expected either `joint` or `between`"),
        ("friction", {"static": 0.5}, "forces.f.static = 0.5: expected coulomb = 1 or above"),
        ("friction", {"static": 2.0}, "forces.f.stribeck_velocity: missing"),
        ("friction", {"rest_velocity": None}, "forces.f.rest_velocity: missing"),
        ("bristle_friction", {"bristle_stifness": 1.0}, "did you mean 'bristle_stiffness'"),
        ("coordinate_force", {"expression": "-k * x"}, "there is no name `k`"),
        ("coordinate_force", {"expression": "joint('rial')"}, "there is no joint rial"),
        ("coordinate_force", {"expression": "position('car.b', 'x')"}, 'no interface "b"'),
        ("coordinate_force", {"expression": "signal('y')"}, "reads no known signal"),
        ("coordinate_force", {"expression": "open('x')"}, "there is no function `open`"),
        ("coordinate_force", {"expression": "rate(v)"}, "has a rate by time that is not known"),
        ("nonlinear_spring", {}, "has no effect; expected force_displacement or force_velocity"),
    ],
)  # fmt: skip
def test_bad_input(tmp_path, kind, change, words):
    keys = {"joint": "rail", **KINDS.get(kind, {}), **change}
    text = carriage(force("f", kind, **{k: v for k, v in keys.items() if v is not None}))
    with pytest.raises(InputError) as caught:
        run(tmp_path, text, 0.1, 0.1)
    assert words in str(caught.value)


def test_a_drive_reads_the_time_alone(tmp_path):
    text = wheel().replace(
        'kind = "revolute"', 'kind = "revolute"\ndrive = { expression = "joint(\'axle\')" }'
    )
    with pytest.raises(InputError, match="expected the time t and parameters alone"):
        run(tmp_path, text, 0.1, 0.1)


def test_an_integrator_without_auxiliary_states_says_so(tmp_path):
    text = wheel(force("coil", "coordinate_force", joint="axle", expression="-2 * x"), spin=1.0)
    with pytest.raises(InputError, match=r"generalized-alpha.*auxiliary states"):
        run(tmp_path, text, 0.1, 0.1, 'integrator = "generalized-alpha"\nconstraints = "ggl"')
