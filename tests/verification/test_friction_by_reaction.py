"""Friction by the reaction of the joint itself: slopes, drawers, bearings, collars."""

from functools import cache

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, RADAU, carriage, force, prepared, run, wheel
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from plymotion.solver.dynamics.evaluation import series
from plymotion.solver.dynamics.evaluation.accelerations import by_blocks, derivative
from plymotion.solver.errors import InputError

G = 9.81
ALPHA = 'integrator = "generalized-alpha"\nconstraints = "ggl"\nrtol = 1e-7'
GEAR = 'integrator = "gear"'
REST = 1e-4


def slope(angle_deg: float, *forces: str, mass: float = 2.0, speed: float = 0.0) -> str:
    """A carriage on a rail down a slope; x points downhill, y out of the slope."""
    a = np.radians(angle_deg)
    gravity = f"gravity = [{G * np.sin(a)}, {-G * np.cos(a)}, 0.0]\n"
    return gravity + carriage(*forces, mass=mass, speed=speed)


def rubbing(**keys) -> str:
    return force("f", "friction", joint="rail", rest_velocity=REST, **keys)


@pytest.mark.parametrize(("length", "jams"), [(0.07, False), (0.05, True)])
@pytest.mark.parametrize("solver", ["", DEFAULT, GEAR])
def test_a_short_guide_jams_by_name(tmp_path, solver, length, jams):
    """A mass 0.1 m beside its guide: friction F at the guide gives it the moment F a, by which it
    needs 2 mu F a / length more. At mu = 0.3 there is no motion for guides below 0.06 m.
    """
    text = carriage(rubbing(coefficient=0.3, length=length), speed=1.0)
    text = text.replace("position = [0.0, 0.0, 0.0]", "position = [0.0, 0.1, 0.0]", 1)
    text = text.replace("a = { position = [0.0, 0.0, 0.0]", "a = { position = [0.0, 0.1, 0.0]", 1)
    _, s, summary = run(tmp_path, f"gravity = [0.0, {-G}, 0.0]\n{text}", 0.01, 0.01, solver)
    if jams:
        assert summary["status"] == "failed"
        assert summary["message"].startswith("Friction would need more reaction than there is")
        assert "forces.f (joint = rail, coefficient = 0.3, length = 0.05)" in summary["message"]
        assert "Expected a longer guide" in summary["message"]
    else:  # F = mu (m g + 2 F a / length)
        force = 0.3 * G / (1.0 - 0.6 * 0.1 / length)
        assert s["v"][-1] == pytest.approx(1.0 - force * 0.01, rel=1e-4)


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT, ALPHA, GEAR])
def test_a_block_slides_down_a_slope(tmp_path, solver):
    """x'' = g (sin a - mu cos a), and the work of friction."""
    mu, a, t_end = 0.3, np.radians(30.0), 0.5
    text = slope(30.0, rubbing(coefficient=mu))
    t, s, summary = run(tmp_path, text, t_end, 0.05, solver)
    down = G * (np.sin(a) - mu * np.cos(a))
    # near rest it is smoothed: the speed gains a few times the rest velocity
    np.testing.assert_allclose(s["x"], 0.5 * down * t**2, atol=5 * REST * t_end)
    np.testing.assert_allclose(s["v"], down * t, atol=5 * REST)
    lost = -mu * 2.0 * G * np.cos(a) * s["x"][-1]
    assert summary["checks"]["drive_work"] == pytest.approx(lost, rel=2e-3)
    assert summary["checks"]["energy_drift_relative"] < (
        1e-3 if solver in (DEFAULT, GEAR) else 1e-5
    )


@pytest.mark.parametrize("solver", ["", RADAU, ALPHA])
def test_a_block_sticks_below_the_angle_of_friction(tmp_path, solver):
    """tan a < mu: it creeps at the speed at which tanh(v / rest_velocity) = tan a / mu."""
    text = slope(10.0, rubbing(coefficient=0.2))
    _, s, _ = run(tmp_path, text, 0.2, 0.1, solver)
    assert s["v"][-1] == pytest.approx(REST * np.arctanh(np.tan(np.radians(10.0)) / 0.2), rel=1e-5)


def test_static_coefficient_holds_what_slides_at_speed(tmp_path):
    """mu < tan a < mu_s: stays if at rest, goes on if it moves."""
    keys = {"coefficient": 0.3, "static_coefficient": 0.6, "stribeck_velocity": 0.01}
    _, s, _ = run(tmp_path, slope(25.0, rubbing(**keys)), 0.2, 0.1, RADAU)
    share = np.tan(np.radians(25.0)) / 0.6
    assert s["v"][-1] == pytest.approx(REST * np.arctanh(share), rel=1e-3)
    t, s, _ = run(tmp_path, slope(25.0, rubbing(**keys), speed=0.5), 0.2, 0.1, RADAU)
    a = np.radians(25.0)
    np.testing.assert_allclose(s["v"], 0.5 + G * (np.sin(a) - 0.3 * np.cos(a)) * t, atol=1e-8)


def test_constant_part_and_reaction_add_up(tmp_path):
    text = slope(40.0, rubbing(coefficient=0.3, coulomb=2.5, viscous=0.0), speed=1.0)
    t, s, _ = run(tmp_path, text, 0.5, 0.1, RADAU)
    a = np.radians(40.0)
    down = G * (np.sin(a) - 0.3 * np.cos(a)) - 2.5 / 2.0
    np.testing.assert_allclose(s["v"], 1.0 + down * t, atol=1e-9)


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
def test_bristles_hold_and_slide_with_the_load(tmp_path, solver):
    """LuGre: below the angle of friction it gives way and stands; above it slides with mu.

    The motion is the same for any mass.
    """
    keys = {"joint": "rail", "coefficient": 0.3, "bristle_stiffness": 1e4, "bristle_damping": 30.0}
    ways = []
    for mass in (2.0, 50.0):
        text = slope(10.0, force("f", "bristle_friction", **keys), mass=mass)
        _, s, _ = run(tmp_path, text, 0.5, 0.25, solver)
        # z = tan a / s0 holds it; it has overshot to less than twice that, and slipped meanwhile
        assert np.tan(np.radians(10.0)) / 1e4 < s["x"][-1] < 2 * 0.3 / 1e4
        assert abs(s["v"][-1]) < 1e-8
        ways.append(s["x"][-1])
        text = slope(30.0, force("f", "bristle_friction", **keys), mass=mass, speed=1.0)
        t, s, _ = run(tmp_path, text, 0.5, 0.25, solver)
        a = np.radians(30.0)
        v = 1.0 + G * (np.sin(a) - 0.3 * np.cos(a)) * t
        v[1:] -= 30.0 * 0.3 / 1e4 * G * np.cos(a)  # the bristle is bent against its damping
        np.testing.assert_allclose(s["v"], v, atol=5e-4)
    assert ways[1] == pytest.approx(ways[0], rel=1e-5 if solver != DEFAULT else 1e-2)


@pytest.mark.parametrize("solver", ["", RADAU, ALPHA])
@pytest.mark.parametrize("offset", [0.1, 0.3])
def test_a_drawer_pulled_beside_its_centre(tmp_path, solver, offset):
    """The moment m a c of inertia loads the guide by 2 m a c / length, which rubs in turn.

    m a = P - mu 2 m a c / length. With 2 mu c / length of 1 or above there are two solutions, or
    none: it jams.
    """
    mu, length, m, pull = 0.5, 0.4, 2.0, 6.0
    text = (
        '[ground.O]\nposition = [0.0, 0.0, 0.0]\n[joints.rail]\nkind = "prismatic"\n'
        'between = ["ground.O", "car.a"]\naxis = [1.0, 0.0, 0.0]\n'
        '[signals.x]\nkind = "joint"\njoint = "rail"\ncoordinate = "z"\n'
        '[signals.v]\nkind = "velocity"\nat = "car.a"\ncomponent = "x"\n'
        '[signals.F]\nkind = "force"\nof = "f"\n'
        + rigid("car", m, 0.1, {"a": (0, -offset, 0)}, position=(0, offset, 0))
        + force("p", "coordinate_force", joint="rail", expression=f"{pull} + 0 * x")
        + rubbing(coefficient=mu, length=length)
    )
    t, s, _ = run(tmp_path, text, 0.5, 0.05, solver)
    a = pull / m / (1.0 + 2.0 * mu * offset / length)
    np.testing.assert_allclose(s["v"], a * t, atol=5 * REST)
    assert s["F"][-1] == pytest.approx(-(pull - m * a), rel=1e-5)


@cache
def pendulum_by_scipy(m, length, inertia, friction, phi_0, times):
    """Angle of a pendulum whose pin rubs with friction times the size of its reaction."""

    def rate(t, y):
        phi, w = y

        def left(a):
            normal = np.hypot(
                m * (G * np.cos(phi) + length * w**2), m * (G * np.sin(phi) + length * a)
            )
            torque = -m * G * length * np.sin(phi) - friction * normal * np.tanh(w / 1e-2)
            return torque - (inertia + m * length**2) * a

        return [w, brentq(left, -1e4, 1e4, xtol=1e-13, rtol=1e-14)]

    found = solve_ivp(rate, (0, times[-1]), [phi_0, 0.0], "Radau", times, rtol=1e-9, atol=1e-11)
    return found.y[0]


@pytest.mark.parametrize(("solver", "virtual"), [("", False), (RADAU, False), (RADAU, True)])
def test_a_pendulum_on_a_rubbing_pin(tmp_path, solver, virtual):
    """Against the equation of one coordinate, in which the reaction depends on acceleration."""
    m, length, inertia, mu, radius = 1.5, 0.3, 0.02, 0.4, 0.05
    text = (
        f"gravity = [0.0, {-G}, 0.0]\n"
        + (
            '[ground.O]\nposition = [0.0, 0.0, 0.0]\n[joints.pin]\nkind = "revolute"\n'
            'between = ["ground.O", "rod.a"]\n'
            '[signals.angle]\nkind = "joint"\njoint = "pin"\ncoordinate = "angle"\n'
        )
        + rigid("rod", m, inertia, {"a": (-length, 0, 0)}, position=(length, 0, 0))
        + force("f", "friction", joint="pin", coefficient=mu, radius=radius, rest_velocity=1e-2)
    )
    more = solver + ('\nattachment = "virtual"' if virtual else "")
    t, s, summary = run(tmp_path, text, 3.0, 0.05, more)
    expected = pendulum_by_scipy(m, length, inertia, mu * radius, np.pi / 2, tuple(t))
    np.testing.assert_allclose(s["angle"], expected - np.pi / 2, atol=2e-6)
    assert summary["checks"]["energy_drift_relative"] < 1e-6


@pytest.mark.parametrize("solver", ["", RADAU, DEFAULT])
@pytest.mark.parametrize(
    ("axis", "arms"), [("x", {"radius": 0.02}), ("z", {"collar_radius": 0.03})]
)
def test_a_rotor_runs_down_by_its_weight(tmp_path, solver, axis, arms):
    """w = w0 - mu r m g t / J on a horizontal axle, by the collar on a vertical one."""
    gravity = [0.0, -G, 0.0] if axis == "x" else [0.0, 0.0, -G]
    text = f"gravity = {gravity}\n" + wheel(
        force("f", "friction", joint="axle", coefficient=0.15, rest_velocity=1e-3, **arms),
        inertia=0.05,
        spin=30.0,
    )
    t, s, summary = run(tmp_path, text, 20.0, 1.0, solver)
    arm = next(iter(arms.values()))
    rate = 0.15 * arm * 2.0 * G / 0.05
    np.testing.assert_allclose(s["w"], np.maximum(30.0 - rate * t, 0.0), atol=1e-2)
    assert summary["checks"]["energy_drift_relative"] < 1e-3


def test_a_bearing_of_some_length_carries_an_overhanging_weight(tmp_path):
    """A shaft whose weight is at c beside the bearing: mu r m g (1 + 2 c / length) / J."""
    text = f"gravity = [0.0, {-G}, 0.0]\n" + (
        '[ground.O]\nposition = [0.0, 0.0, 0.0]\n[joints.axle]\nkind = "cylindrical"\n'
        'between = ["ground.O", "wheel.a"]\ntranslation_drive = { speed = 0.0 }\n'
        '[signals.w]\nkind = "angular_velocity"\nat = "wheel.a"\ncomponent = "z"\n'
    ) + rigid("wheel", 2.0, 0.05, {"a": (0, 0, -0.3)}, position=(0, 0, 0.3),
              angular_velocity=(0, 0, 30.0)) + force(
        "f", "friction", joint="axle", coordinate="angle", coefficient=0.1, radius=0.02,
        length=0.2, rest_velocity=1e-3,
    )  # fmt: skip
    t, s, _ = run(tmp_path, text, 2.0, 0.5)
    rate = 0.1 * 0.02 * 2.0 * G * (1 + 2 * 0.3 / 0.2) / 0.05
    np.testing.assert_allclose(s["w"], 30.0 - rate * t, atol=1e-8)


def test_accelerations_are_the_same_by_dense_matrices(tmp_path):
    """Elimination body by body, and the route of redundant constraints."""
    text = slope(30.0, rubbing(coefficient=0.3, length=0.3), speed=1.0)
    model, y = prepared(tmp_path, text)
    assert by_blocks(model)
    one = derivative(model, 0.0, y)
    rates = series.along_solution(model, np.zeros(1), y[None])[0][0]
    np.testing.assert_allclose(rates, one, atol=1e-12)
    np.testing.assert_allclose(
        derivative(model._replace(redundant=1), 0.0, y), one, rtol=1e-9, atol=1e-10
    )
    expected = G * (np.sin(np.radians(30.0)) - 0.3 * np.cos(np.radians(30.0)))
    assert one[model.n_pos] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        ("friction", {"coefficient": None}, "has no effect; expected coulomb or coefficient"),
        ("friction", {"coefficient": -0.1}, "forces.f.coefficient = -0.1: value should be greater"),
        ("friction", {"static_coefficient": 0.1}, "static_coefficient = 0.1: expected coefficient"),
        ("friction", {"static_coefficient": 0.5}, "forces.f.stribeck_velocity: missing"),
        ("friction", {"coefficient": None, "coulomb": 1.0, "radius": 0.1},
         "forces.f.radius = 0.1: expected with coefficient only"),
        ("friction", {"collar_radius": 0.1}, "collar_radius: expected with the angle"),
        ("friction", {"joint": None, "between": ["ground.O", "car.a"]},
         "forces.f.coefficient: expected with the angle or z of a revolute"),
        ("bristle_friction", {"coulomb": 1.0}, "forces.f.coulomb: expected without coefficient"),
        ("friction", {"coeficient": 0.2}, "did you mean 'coefficient'"),
    ],
)  # fmt: skip
def test_bad_input(tmp_path, kind, change, words):
    own = {"rest_velocity": 0.1} if kind == "friction" else {"bristle_stiffness": 1e3}
    keys = {"joint": "rail", "coefficient": 0.3, **own, **change}
    if "coeficient" in keys:
        del keys["coefficient"]
    text = carriage(force("f", kind, **{k: v for k, v in keys.items() if v is not None}))
    with pytest.raises(InputError) as caught:
        run(tmp_path, text, 0.1, 0.1)
    assert words in str(caught.value)


def test_a_hinge_needs_a_radius(tmp_path):
    text = wheel(force("f", "friction", joint="axle", coefficient=0.1, rest_velocity=0.1))
    with pytest.raises(InputError, match=r"forces\.f\.radius: missing"):
        run(tmp_path, text, 0.1, 0.1)


@pytest.mark.parametrize("solver", [RADAU, DEFAULT])
def test_a_shaft_that_turns_and_slides_has_one_friction(tmp_path, solver):
    """A thin tube on a shaft: against the velocity of the contact, whose direction stays.

    Each component falls by its share of mu g; two frictions would stop both at mu g each.
    """
    mu, R, m, v, w = 0.2, 0.05, 3.0, 0.6, 16.0  # contact 0.6 m/s along, 0.8 m/s around
    text = (
        f"gravity = [0.0, -{G}, 0.0]\n[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
        + rigid("tube", m, [0.1, 0.1, m * R**2], {"a": (0, 0, 0)},
                velocity=(0, 0, v), angular_velocity=(0, 0, w))
        + '[joints.shaft]\nkind = "cylindrical"\nbetween = ["ground.O", "tube.a"]\n'
        + "axis = [0.0, 0.0, 1.0]\n"
        + '[signals.v]\nkind = "velocity"\nat = "tube.a"\ncomponent = "z"\n'
        + '[signals.w]\nkind = "angular_velocity"\nat = "tube.a"\ncomponent = "z"\n'
        + force("along", "friction", joint="shaft", coordinate="z", coefficient=mu, radius=R,
                rest_velocity=1e-4)
        + force("around", "friction", joint="shaft", coordinate="angle", coefficient=mu,
                radius=R, rest_velocity=1e-4 / R)
    )  # fmt: skip
    t, s, summary = run(tmp_path, text, 0.6, 0.05, solver)
    left = np.maximum(0.0, 1.0 - mu * G * t / 1.0)
    np.testing.assert_allclose(s["v"], v * left, atol=1e-3)
    np.testing.assert_allclose(s["w"], w * left, atol=1e-3 * w)
    assert summary["checks"]["energy_drift_relative"] < 1e-3
