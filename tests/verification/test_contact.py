"""Contacts of spheres, planes and discs against closed forms."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, RADAU, force, run

from plymotion.solver.errors import InputError

G = 9.81
FLOOR = f"gravity = [0.0, 0.0, -{G}]\n[ground.floor]\nposition = [0.0, 0.0, 0.0]\n"


def body(name: str, mass: float, inertia: float, **keys) -> str:
    return rigid(name, mass, inertia, {"c": [0.0, 0.0, 0.0]}, **keys)


def contact(one: str, two: str, **keys) -> str:
    return force("k", "contact", between=[one, two], **keys)


def signals(name: str, *kinds: str) -> str:
    return "".join(
        f'[signals.{name}_{kind}_{axis}]\nkind = "{kind}"\nat = "{name}.c"\ncomponent = "{axis}"\n'
        for kind in kinds
        for axis in "xyz"
    )


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_a_bouncing_ball(tmp_path, radius):
    """It leaves each impact at e times the speed before, and flies 2 v / g to the next."""
    e, h = 0.8, 0.5
    text = FLOOR + body("ball", 2.0, 8e-3, position=[0.0, 0.0, h + radius])
    text += contact("ground.floor", "ball.c", radius=radius, stiffness=1e11, restitution=e)
    text += signals("ball", "position", "velocity")
    t, s, summary = run(tmp_path, text, 2.0, 1e-3)
    v, begin = sqrt(2.0 * G * h), sqrt(2.0 * h / G)
    for bounce in range(1, 4):
        v *= e
        inside = (t > begin + 0.01) & (t < begin + 2.0 * v / G - 0.01)
        assert inside.sum() > 200
        late = 1e-3 * bounce  # an impact takes 0.1 ms, and flights begin behind it
        path = v * (t[inside] - begin) - 0.5 * G * (t[inside] - begin) ** 2
        np.testing.assert_allclose(s["ball_position_z"][inside] - radius, path, atol=late * v)
        energy = G * (s["ball_position_z"] - radius) + 0.5 * s["ball_velocity_z"] ** 2
        np.testing.assert_allclose(energy[inside], 0.5 * v**2, rtol=1e-3)
        begin += 2.0 * v / G
    assert summary["warnings"] == []


@pytest.mark.parametrize("times", [1.0, 30.0])
def test_a_ball_that_begins_in_the_floor_is_not_held_there(tmp_path, times):
    """At its static depth it rests; from a larger depth it leaves, with less than its energy."""
    k, mass = 1e6, 2.0
    depth = times * (mass * G / k) ** (1.0 / 1.5)
    text = FLOOR + body("ball", mass, 8e-3, position=[0.0, 0.0, 0.1 - depth])
    text += contact("ground.floor", "ball.c", radius=0.1, stiffness=k, restitution=0.8)
    text += signals("ball", "position")
    _, s, _ = run(tmp_path, text, 0.1, 1e-3)
    z = s["ball_position_z"] - 0.1
    if times == 1.0:
        np.testing.assert_allclose(z, -depth, rtol=1e-6)
    else:
        height = k * depth**2.5 / 2.5 / (mass * G) - depth  # of an elastic contact
        assert 0.05 * height < z.max() < height


@pytest.mark.parametrize("t_end", [1.0, 2.0])
def test_spheres_that_meet_off_centre_within_one_step(tmp_path, t_end):
    """Free bodies take steps as long as the run: one once passed through the other unseen."""
    m, r, u, b, e = (1.0, 3.0), 0.1, 2.0, 0.12, 0.7
    text = body("a", m[0], 4e-3, position=[-1.0, 0.0, 0.0], velocity=[u, 0.0, 0.0])
    text += body("b", m[1], 12e-3, position=[0.0, b, 0.0])
    text += contact("a.c", "b.c", radius=r, other_radius=r, stiffness=1e12, restitution=e)
    text += signals("a", "velocity") + signals("b", "velocity")
    _, s, _ = run(tmp_path, text, t_end, 0.1)
    n = np.array([sqrt(4.0 * r * r - b * b), b]) / (2.0 * r)
    impulse = (1.0 + e) * m[0] * m[1] / sum(m) * u * n[0] * n
    for name, begin, push in (("a", [u, 0.0], -impulse / m[0]), ("b", [0.0, 0.0], impulse / m[1])):
        found = [s[f"{name}_velocity_{axis}"][-1] for axis in "xy"]
        np.testing.assert_allclose(found, begin + push, atol=1e-3 * u)


def test_two_spheres_exchange_their_velocities(tmp_path):
    """Hertz: the deepest indentation is (5 m u^2 / (4 k))^(2/5), m being both masses in series."""
    k, mass, u, r = 1e6, 0.5, 2.0, 0.05
    text = body("a", mass, 5e-4, position=[-0.2, 0.0, 0.0], velocity=[u, 0.0, 0.0])
    text += body("b", mass, 5e-4, position=[0.1, 0.0, 0.0])
    text += contact("a.c", "b.c", radius=r, other_radius=r, stiffness=k)
    text += signals("a", "velocity") + signals("b", "velocity")
    text += '[signals.N]\nkind = "force"\nof = "k"\n'
    _, s, summary = run(tmp_path, text, 0.2, 1e-5)
    assert s["a_velocity_x"][-1] == pytest.approx(0.0, abs=1e-7)
    assert s["b_velocity_x"][-1] == pytest.approx(u, rel=1e-7)
    deepest = (5.0 * 0.5 * mass * u**2 / (4.0 * k)) ** 0.4
    assert s["N"].max() == pytest.approx(k * deepest**1.5, rel=1e-4)
    assert summary["warnings"] == []
    # A step that begins where the spheres touch could be so long that they pass each other.
    _, s, summary = run(tmp_path, text, 0.2, 0.05, 'integrator = "rk8"')
    assert s["b_velocity_x"][-1] == pytest.approx(u, rel=1e-5)
    assert summary["warnings"] == []


def test_a_blow_off_centre_keeps_all_momenta(tmp_path):
    """Friction turns both spheres; what they lose in sliding is work done on the system."""
    text = body("a", 0.5, 5e-4, position=[-0.2, 0.0, 0.0], velocity=[2.0, 0.5, 0.0])
    text += body("b", 0.3, 2e-4, position=[0.1, 0.03, 0.04])
    text += contact(
        "a.c",
        "b.c",
        radius=0.05,
        other_radius=0.07,
        stiffness=1e6,
        restitution=0.6,
        coefficient=0.4,
    )
    text += "".join(signals(n, "position", "velocity", "angular_velocity") for n in "ab")
    _, s, summary = run(tmp_path, text, 0.25, 0.05)
    total = np.zeros((2, 6))
    for name, mass, inertia in (("a", 0.5, 5e-4), ("b", 0.3, 2e-4)):
        x, v, w = (
            np.stack([s[f"{name}_{kind}_{axis}"] for axis in "xyz"], -1)
            for kind in ("position", "velocity", "angular_velocity")
        )
        for row, at in zip(total, (0, -1), strict=True):
            row[:3] += mass * v[at]
            row[3:] += mass * np.cross(x[at], v[at]) + inertia * w[at]
    assert abs(s["b_angular_velocity_y"][-1]) > 1.0
    # The arms of both end in one point, but for the depth of the indentation.
    np.testing.assert_allclose(total[1, :3], total[0, :3], atol=1e-9)
    np.testing.assert_allclose(total[1, 3:], total[0, 3:], atol=1e-9)
    assert summary["checks"]["energy_drift_relative"] < 1e-8


def test_a_sliding_ball_begins_to_roll(tmp_path):
    """At 2 u / (7 mu g), with 5/7 of its speed."""
    mass, r, u, mu, k = 2.0, 0.1, 2.0, 0.3, 1e7
    depth = (mass * G / k) ** (2.0 / 3.0)
    text = FLOOR + body(
        "ball", mass, 0.4 * mass * r**2, position=[0, 0, r - depth], velocity=[u, 0, 0]
    )
    text += contact(
        "ground.floor", "ball.c", radius=r, stiffness=k, coefficient=mu, rest_velocity=1e-5
    )
    text += signals("ball", "position", "velocity")
    _, s, _ = run(tmp_path, text, 0.5, 0.1, RADAU)
    rolls = 2.0 * u / (7.0 * mu * G)
    way = u * rolls - 0.5 * mu * G * rolls**2 + (0.5 - rolls) * 5.0 / 7.0 * u
    # Surfaces touch at r, the arm of the friction is r - depth: 4 parts in 1e5 of r.
    assert s["ball_velocity_x"][-1] == pytest.approx(5.0 / 7.0 * u, rel=1e-4)
    assert s["ball_position_x"][-1] == pytest.approx(way, rel=1e-4)


@pytest.mark.parametrize("smoothed", [1e-5, 1e-4])  # rtol, and ten times of it
def test_a_ball_slides_from_rest(tmp_path, smoothed):
    """Down a slope that is too steep to roll; the friction is less while it begins to slide."""
    angle, mass, r, mu, k = 0.7, 2.0, 0.1, 0.1, 1e7
    weight = mass * G * cos(angle)
    arm, n = r - (weight / k) ** (2.0 / 3.0), [-sin(angle), 0.0, cos(angle)]
    text = FLOOR + body("ball", mass, 0.4 * mass * r**2, position=[arm * v for v in n])
    how = {"radius": r, "stiffness": k, "coefficient": mu, "rest_velocity": smoothed}
    text += contact("ground.floor", "ball.c", axis=n, **how)
    text += signals("ball", "velocity", "angular_velocity")
    _, s, _ = run(tmp_path, text, 0.5, 0.1, DEFAULT)
    slides = G * (sin(angle) - mu * cos(angle)) * 0.5
    down = -cos(angle) * s["ball_velocity_x"][-1] - sin(angle) * s["ball_velocity_z"][-1]
    assert down == pytest.approx(slides, abs=smoothed)
    turns = 2.5 * mu * G * cos(angle) / r * 0.5
    found = abs(s["ball_angular_velocity_y"][-1])
    assert found == pytest.approx(turns, rel=1e-4, abs=10.0 * smoothed / r)


def test_a_spinning_ball_on_a_moving_belt(tmp_path):
    """It ends with 5/7 of its speed over the belt and 2/7 of that of its surface, in both axes.

    Friction acts at the belt, so that the moment of momentum about the line of contact stays.
    """
    k, mass, radius, belt = 1e8, 2.0, 0.1, 1.0
    depth = (mass * G / k) ** (1.0 / 1.5)
    turns = {"velocity": [0.2, 0.5, 0.0], "angular_velocity": [10.0, -25.0, 40.0]}
    text = FLOOR + body("belt", 5.0, 1.0)
    text += body("ball", mass, 8e-3, position=[0.0, 0.0, radius - depth], **turns)
    text += '[joints.belt]\nkind = "prismatic"\nbetween = ["ground.floor", "belt.c"]\n'
    text += f"axis = [1.0, 0.0, 0.0]\ndrive = {{ polynomial = [0.0, {belt}] }}\n"
    how = {"radius": radius, "stiffness": k, "impact_speed": 1.0, "restitution": 0.5}
    text += contact("belt.c", "ball.c", **how, coefficient=0.3, rest_velocity=1e-4)
    text += signals("ball", "velocity")
    _, s, summary = run(tmp_path, text, 0.4, 0.1)
    x = belt + (5.0 * (0.2 - belt) + 2.0 * radius * -25.0) / 7.0
    y = (5.0 * 0.5 - 2.0 * radius * 10.0) / 7.0
    assert s["ball_velocity_x"][-1] == pytest.approx(x, abs=1e-7)
    assert s["ball_velocity_y"][-1] == pytest.approx(y, abs=1e-7)
    assert s["ball_velocity_x"][1] > x + 0.1  # still sliding
    assert summary["warnings"] == []


@pytest.mark.parametrize("part", [0.5, 0.9])
def test_a_foot_creeps_below_the_friction_that_it_can_have(tmp_path, part):
    """Three points under a block: rest_velocity p / (1 - p^2)^(1/2) at the part p of friction."""
    k, mass, mu, rest = 1e6, 3.0, 0.6, 5e-3
    depth = (mass * G / 3.0 / k) ** (1.0 / 1.5)
    feet = {"f1": [0.2, 0.0, 0.0], "f2": [-0.1, 0.2, 0.0], "f3": [-0.1, -0.2, 0.0]}
    text = FLOOR + rigid(
        "block", mass, 0.05, {"c": [0.0, 0.0, 0.0], **feet}, position=[0.0, 0.0, -depth]
    )
    how = {"radius": 0.0, "stiffness": k, "impact_speed": 0.5, "restitution": 0.3}
    for foot in feet:
        keys = {"between": ["ground.floor", f"block.{foot}"], **how}
        text += force(f"k_{foot}", "contact", **keys, coefficient=mu, rest_velocity=rest)
    text += force("push", "force", at="block.c", direction=[1.0, 0.0, 0.0])
    text += f"law = {{ constant = {part * mu * mass * G} }}\n"
    _, s, _ = run(tmp_path, text + signals("block", "velocity"), 0.3, 0.1)
    creep = rest * part / sqrt(1.0 - part**2)
    assert s["block_velocity_x"][-1] == pytest.approx(creep, rel=1e-6)


def test_a_tilted_disc_rolls_in_a_circle(tmp_path):
    """Steady rolling of a thin disc of mass m and radius r, its axis at theta to the vertical.

    With A = m r^2 / 4, C = 2 A, the precession W about the vertical and the spin w about the axis,
    Newton and Euler give
    (C + m r^2) w W sin(theta) - A W^2 sin(theta) cos(theta) + m g r cos(theta) = 0; the centre
    moves in a circle of radius r |w / W|.
    """
    mass, r, theta, W, k = 2.0, 0.3, 1.2, 3.0, 1e8
    A = mass * r**2 / 4.0
    C = 2.0 * A
    turning = A * W**2 * sin(theta) * cos(theta) - mass * G * r * cos(theta)
    w = turning / ((C + mass * r**2) * W * sin(theta))
    a = np.array([sin(theta), 0.0, cos(theta)])  # axis of the disc
    up = np.array([-cos(theta), 0.0, sin(theta)])  # from where it touches to the centre
    spin = w * a + W * sin(theta) * up
    height = r * sin(theta) - (mass * G / k) ** (2.0 / 3.0)
    disc = body(
        "disc",
        mass,
        1.0,
        position=[0, 0, height],
        velocity=np.cross(spin, r * up),
        angular_velocity=spin,
    )
    inertia = (A * np.eye(3) + (C - A) * np.outer(a, a)).tolist()
    text = FLOOR + disc.replace(str(np.eye(3).tolist()), str(inertia))
    text += contact(
        "ground.floor",
        "disc.c",
        radius=r,
        disc_axis=a.tolist(),
        stiffness=k,
        coefficient=1.0,
        rest_velocity=1e-5,
    ) + signals("disc", "position")
    _, s, _ = run(tmp_path, text, 2.0 * pi / W, 2.0 * pi / W / 40, RADAU)
    circle = r * abs(w / W)
    assert circle > 0.1
    for axis, start in (("x", 0.0), ("y", 0.0), ("z", height)):
        assert s[f"disc_position_{axis}"][-1] == pytest.approx(start, abs=1e-3 * circle)
    assert np.ptp(s["disc_position_y"]) == pytest.approx(2.0 * circle, rel=1e-3)
    assert np.ptp(s["disc_position_z"]) < 1e-4 * r


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"axis": [0, 0, 1], "other_radius": 0.1}, "forces.k.axis: expected with a plane only"),
        ({"disc_axis": [0, 1, 0]}, "forces.k.radius = 0: expected the radius of the disc"),
        ({"radius": -1.0}, "forces.k.radius = -1.0"),
        ({"restitution": 0.0}, "forces.k.restitution = 0.0"),
        ({"between": ["ground.floor", "ball.d"]}, 'forces.k.between = "ball.d": body "ball"'),
    ],
)
def test_bad_input(tmp_path, keys, words):
    given = {"between": ["ground.floor", "ball.c"], "stiffness": 1e6, **keys}
    text = FLOOR + body("ball", 1.0, 1.0) + force("k", "contact", **given)
    with pytest.raises(InputError) as caught:
        run(tmp_path, text, 0.1, 0.1)
    assert words in str(caught.value)
