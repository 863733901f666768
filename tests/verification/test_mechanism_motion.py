"""Joints, drives and forces of a case file against closed forms of their motion."""

import numpy as np
import pytest
from samples.case_samples import rigid, run_text

COMMON = {"a": (0, 0, 0), "b": (1, 0, 0)}
GRAVITY = "gravity = [0.0, -9.81, 0.0]\n"
GROUND = "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"


def joint(name, kind, one, two, **keys):
    more = "\n".join(f"{key} = {value}" for key, value in keys.items())
    return f'[joints.{name}]\nkind = "{kind}"\nbetween = ["{one}", "{two}"]\n{more}\n'


def measure(name, kind, **keys):
    more = "\n".join(
        f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}"
        for key, value in keys.items()
    )
    return f'[signals.{name}]\nkind = "{kind}"\n{more}\n'


def test_hookes_joint(tmp_path):
    """Two shafts at an angle: tan(output) = tan(input) cos(angle), turn after turn."""
    angle = np.radians(30.0)
    axis = [float(np.cos(angle)), float(np.sin(angle)), 0.0]
    text = (
        GROUND
        + "[ground.far]\nposition = [1.0, 0.0, 0.0]\n"
        + rigid("inlet", 1.0, 0.1, {"a": (0, 0, 0)})
        + rigid("outlet", 1.0, 0.1, {"a": (0, 0, 0), "b": (*axis[:2], 0)})
        + "[ground.end]\nposition = " + str(axis) + "\n"
        + joint("shaft", "revolute", "ground.O", "inlet.a", axis="[1, 0, 0]",
                drive="{ ramp = { speed = 20.0, duration = 0.1 } }")
        + joint("cross", "universal", "inlet.a", "outlet.a", axis="[0, 0, 1]",
                axis_2=[-axis[1], axis[0], 0.0])
        + joint("bearing", "point_on_line", "ground.end", "outlet.b", axis=axis)
        + measure("inlet", "joint", joint="shaft", coordinate="angle")
        + measure("one", "joint", joint="cross", coordinate="angle")
        + measure("two", "joint", joint="cross", coordinate="angle_2")
        + "".join(measure(f"w{c}", "angular_velocity", at="outlet.a", component=c) for c in "xyz")
    )  # fmt: skip
    t, s, _ = run_text(tmp_path, text, t_end=1.0, step=0.001)
    assert s["inlet"][-1] == pytest.approx(1.0 + 18.0, abs=1e-8)  # three turns
    # The arm of the cross in the inlet starts along z, at a right angle to both shafts.
    rate = np.array([s["wx"], s["wy"], s["wz"]]).T @ axis
    speed = np.gradient(s["inlet"], t)[200:-1]
    phi = s["inlet"][200:-1]
    expected = speed * np.cos(angle) / (1.0 - np.sin(angle) ** 2 * np.sin(phi) ** 2)
    np.testing.assert_allclose(rate[200:-1], expected, rtol=1e-6)
    # Each arm swings by twice the angle of the shafts; the first starts at an end of its swing.
    assert np.ptp(s["one"]) == pytest.approx(2 * angle, rel=1e-4)
    assert np.ptp(s["two"]) == pytest.approx(2 * angle, rel=1e-4)
    assert s["two"].max() == pytest.approx(angle, rel=1e-4)


SPATIAL_CRANK = (
    "gravity = [0.0, 0.0, -9.81]\n"
    "[ground.A]\nposition = [0.0, 0.1, 0.12]\n[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("crank", 0.12, [1e-4, 1e-5, 1e-4], {"A": (0, 0, -0.04), "B": (0, 0, 0.04)},
            position=(0, 0.1, 0.16))
    + rigid("rod", 0.5, [4e-4, 4e-3, 4e-3], {"B": (-0.15, 0, 0), "C": (0.15, 0, 0)},
            position=(0.1, 0.05, 0.1), rotation_deg=(0.0, 41.8, -22.0))
    + rigid("slider", 2.0, 1e-4, {"C": (0, 0, 0)}, position=(0.2, 0, 0))
    + joint("A", "revolute", "ground.A", "crank.A", axis=[1, 0, 0], drive="{ speed = 6.0 }")
    + joint("B", "spherical", "crank.B", "rod.B")
    + joint("C", "universal", "slider.C", "rod.C", axis=[0, 1, 0], axis_2=[1, 0, 1])
    + joint("guide", "prismatic", "ground.O", "slider.C", axis=[1, 0, 0])
    + measure("x", "position", at="slider.C", component="x")
    + measure("v", "velocity", at="slider.C", component="x")
    + measure("z", "joint", joint="guide", coordinate="z")
    + measure("torque", "reaction", joint="A", quantity="moment", axes="joint", component="z")
)  # fmt: skip


def test_spatial_slider_crank(tmp_path):
    """IFToMM's spatial slider crank from a rough start: kinematics and the work of the drive."""
    t, s, summary = run_text(tmp_path, SPATIAL_CRANK, t_end=2.0, step=0.005)
    y, z = 0.1 - 0.08 * np.sin(6.0 * t), 0.12 + 0.08 * np.cos(6.0 * t)
    expected = np.sqrt(0.09 - y**2 - z**2)
    np.testing.assert_allclose(s["x"], expected, atol=1e-9)
    np.testing.assert_allclose(s["z"], s["x"] - 0.2, atol=1e-12)
    assert s["v"][0] == pytest.approx(0.24, abs=1e-9)  # as the benchmark says
    work = np.trapezoid(s["torque"] * 6.0, t)
    assert work == pytest.approx(summary["checks"]["drive_work"], rel=1e-3)
    assert summary["checks"]["energy_drift_relative"] < 1e-9


def test_helix(tmp_path):
    """Both coordinates of a cylindrical joint driven: a point on a screw line, from its start."""
    text = (
        GROUND
        + rigid("nut", 1.0, 0.1, {"a": (0, 0, 0), "b": (0.5, 0, 0)}, position=(0, 0, 0.3))
        + joint("screw", "cylindrical", "ground.O", "nut.a", axis=[0, 0, 1],
                rotation_drive="{ speed = 40.0, angle = 7.0 }",
                translation_drive="{ smooth_step = { value = 0.2, duration = 0.5 } }")
        + "".join(measure(c, "position", at="nut.b", component=c) for c in "xyz")
        + measure("angle", "joint", joint="screw", coordinate="angle")
        + measure("height", "joint", joint="screw", coordinate="z")
    )  # fmt: skip
    # an output step of 1.3 turns: no angle can be told from the positions alone
    t, s, _ = run_text(tmp_path, text, t_end=2.0, step=0.2)
    np.testing.assert_allclose(s["angle"], 7.0 + 40.0 * t, atol=1e-8)
    np.testing.assert_allclose(s["x"], 0.5 * np.cos(7.0 + 40.0 * t), atol=1e-8)
    u = np.clip(t / 0.5, 0, 1)
    rise = 0.2 * (10 * u**3 - 15 * u**4 + 6 * u**5)
    np.testing.assert_allclose(s["height"], rise, atol=1e-9)
    np.testing.assert_allclose(s["z"], 0.3 + rise, atol=1e-9)


def test_orientation_has_no_jumps(tmp_path):
    """The rotation vector passes a half turn, a whole turn, and comes back."""
    text = (
        GROUND
        + rigid("arm", 1.0, 0.1, COMMON)
        + joint("hinge", "revolute", "ground.O", "arm.a", axis=[1, 2, 2],
                drive="{ polynomial = [0.0, 20.0, -10.0] }")
        + "".join(measure(c, "orientation", at="arm.b", component=c) for c in "xyz")
    )  # fmt: skip
    t, s, _ = run_text(tmp_path, text, t_end=2.0, step=0.01)
    angle = 20.0 * t - 10.0 * t**2  # up to 10 rad and back
    for c, share in zip("xyz", (1 / 3, 2 / 3, 2 / 3), strict=True):
        np.testing.assert_allclose(s[c], share * angle, atol=1e-8)


def test_reactions_of_a_pendulum(tmp_path):
    """Force and moment of the hinge are what moves the mass, on both sides of the hinge."""
    text = (
        GRAVITY + GROUND
        + rigid("arm", 2.0, 0.3, {"a": (-0.6, 0, 0), "c": (0, 0, 0)}, position=(0.6, 0, 0))
        + joint("hinge", "revolute", "ground.O", "arm.a", drive="{ polynomial = [0, 0, 1.5] }")
        + "".join(measure(f"a{c}", "acceleration", at="arm.c", component=c) for c in "xy")
        + "".join(
            measure(f"{q[0]}{side}{c}", "reaction", joint="hinge", quantity=q, side=side,
                    component=c)
            for q in ("force", "moment") for side in (1, 2) for c in "xyz"
        )
    )  # fmt: skip
    t, s, _ = run_text(tmp_path, text, t_end=1.0, step=0.01)
    angle, speed = 1.5 * t**2, 3.0 * t
    np.testing.assert_allclose(
        s["ax"], 0.6 * (-(speed**2) * np.cos(angle) - 3.0 * np.sin(angle)), atol=1e-7
    )
    np.testing.assert_allclose(s["f2x"], 2.0 * s["ax"], atol=1e-7)
    np.testing.assert_allclose(s["f2y"], 2.0 * (s["ay"] + 9.81), atol=1e-7)
    weight = 2.0 * 9.81 * 0.6 * np.cos(angle)
    np.testing.assert_allclose(s["m2z"], (0.3 + 2.0 * 0.36) * 3.0 + weight, atol=1e-7)
    for q in "fm":
        for c in "xyz":
            np.testing.assert_allclose(s[f"{q}1{c}"], -s[f"{q}2{c}"], atol=1e-9)


def test_reaction_across_a_distance(tmp_path):
    """A guide with an arm: force and moment on both sides balance about one point."""
    text = (
        GRAVITY + GROUND
        + rigid("block", 2.0, 0.3, {"a": (0, 0.5, 0)}, position=(0.7, -0.5, 0))
        + joint("guide", "prismatic", "ground.O", "block.a", axis=[1, 0, 0],
                drive="{ polynomial = [0, 0, 1.0] }")
        + "".join(
            measure(f"{q[0]}{side}{c}", "reaction", joint="guide", quantity=q, side=side,
                    component=c)
            for q in ("force", "moment") for side in (1, 2) for c in "xyz"
        )
    )  # fmt: skip
    t, s, _ = run_text(tmp_path, text, t_end=1.0, step=0.1)
    x = 0.7 + t**2
    np.testing.assert_allclose(s["f2x"], 4.0, atol=1e-9)  # 2 kg at 2 m/s2
    np.testing.assert_allclose(s["f2y"], 2.0 * 9.81, atol=1e-9)
    # about the block's place 0.5 m above its middle: the force at the middle's height is missing
    np.testing.assert_allclose(s["m2z"], 4.0 * 0.5, atol=1e-9)
    np.testing.assert_allclose(s["m1z"], -(s["m2z"] + x * s["f2y"]), atol=1e-9)


def test_mass_on_a_spring_from_equilibrium(tmp_path):
    """Held by gravity at m g / k; pushed by a step, it swings about its new place."""
    text = (
        GRAVITY
        + "[ground.O]\nposition = [0.0, 2.0, 0.0]\n"
        + rigid("ball", 0.5, 0.1, {"a": (0, 0, 0)}, position=(0, 0.9, 0))
        + joint("guide", "prismatic", "ground.O", "ball.a", axis=[0, 1, 0])
        + '[forces.coil]\nkind = "spring"\nbetween = ["ground.O", "ball.a"]\nstiffness = 200.0\n'
          "length = 1.0\n"
        + '[forces.push]\nkind = "force"\nat = "ball.a"\ndirection = [0, -1, 0]\n'
          "law = { table = { times = [0.0, 0.1, 10.0], values = [0.0, 4.0, 4.0], "
          'interpolation = "linear" } }\n'
        + measure("y", "position", at="ball.a", component="y")
    )  # fmt: skip
    t, s, _ = run_text(tmp_path, text, t_end=1.0, step=0.01, more='start = "equilibrium"')
    assert s["y"][0] == pytest.approx(1.0 - 0.5 * 9.81 / 200.0, abs=1e-9)
    w, rise = 20.0, 0.1
    ramp = np.where(t < rise, t - np.sin(w * t) / w,
                    rise + (np.sin(w * (t - rise)) - np.sin(w * t)) / w)  # fmt: skip
    np.testing.assert_allclose(s["y"], s["y"][0] - 4.0 / 200.0 * ramp / rise, atol=1e-8)


def test_bushing_and_rotary_spring_in_parallel(tmp_path):
    """A body in a bushing that is stiff but about z: the rotary springs add up."""
    text = (
        GROUND
        + rigid("disc", 2.0, 0.05, {"a": (0, 0, 0)}, angular_velocity=(0, 0, 0.5),
                velocity=(0, 0, 0))
        + '[forces.mount]\nkind = "bushing"\nbetween = ["ground.O", "disc.a"]\n'
          "stiffness = [1e4, 1e4, 1e4]\nrotary_stiffness = [1e3, 1e3, 4.0]\n"
        + '[forces.coil]\nkind = "rotary_spring"\nbetween = ["ground.O", "disc.a"]\n'
          "stiffness = 1.0\n"
        + measure("turn", "orientation", at="disc.a", component="z")
    )  # fmt: skip
    t, s, _ = run_text(tmp_path, text, t_end=2.0, step=0.01)
    w = np.sqrt(5.0 / 0.05)
    np.testing.assert_allclose(s["turn"], 0.5 / w * np.sin(w * t), atol=1e-8)


def test_pendulum_on_a_massless_rod(tmp_path, published):
    """A01 of the IFToMM library as a distance: a mass point, its rotations free."""
    reference = published("a01_pendulum")
    text = (
        f"gravity = [0.0, {-reference['gravity']}, 0.0]\n" + GROUND
        + rigid("bob", 1.0, 1.0, {"a": (0, 0, 0)}, position=(-1, 0, 0))
        + joint("rod", "distance", "ground.O", "bob.a")
        + "".join(measure(c, "position", at="bob.a", component=c) for c in "xy")
    )  # fmt: skip
    _, s, _ = run_text(tmp_path, text, t_end=5.0, step=1.0)
    point = next(p for p in reference["positions"] if p["t"] == 5.0)
    assert np.hypot(s["x"][-1] - point["x"], s["y"][-1] - point["y"]) < reference["tolerance"]
