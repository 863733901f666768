"""State space and transfer functions of `plymotion modes` against closed forms and runs."""

import csv

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, computed_file, rigid
from samples.modes_samples import write_case_text
from scipy.io import loadmat

from plymotion.solver.__main__ import main

PENDULUM = (
    "gravity = [0.0, -9.81, 0.0]\n[ground.pin]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("rod", 2.0, 0.1, {"pin": (0, 0.5, 0), "end": (0, -0.5, 0)}, position=[0, -0.5, 0])
    + """
[joints.pin]
kind = "revolute"
between = ["ground.pin", "rod.pin"]
axis = [0.0, 0.0, 1.0]
[forces.pin]
kind = "rotary_spring"
between = ["ground.pin", "rod.pin"]
axis = [0.0, 0.0, 1.0]
damping = 0.3
actuator = { constant = 0.0 }
[signals.angle]
kind = "joint"
joint = "pin"
coordinate = "angle"
[signals.push]
kind = "reaction"
joint = "pin"
quantity = "force"
component = "x"
"""
)

SLIDE = (
    "[ground.rail]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("carriage", 1.0, 0.1, {"c": (0, 0, 0)})
    + rigid("load", 2.0, 0.1, {"c": (0, 0, 0)}, position=[1.0, 0.0, 0.0])
    + "".join(
        f'[joints.{name}]\nkind = "prismatic"\nbetween = ["{one}", "{two}"]\n'
        f"axis = [1.0, 0.0, 0.0]\n{more}\n"
        for name, one, two, more in (
            ("rail", "ground.rail", "carriage.c", "drive = { speed = 0.0 }"),
            ("slide", "carriage.c", "load.c", ""),
        )
    )
    + """
[forces.coil]
kind = "spring"
between = ["carriage.c", "load.c"]
stiffness = 80.0
damping = 1.5
length = 1.0
[signals.place]
kind = "position"
at = "load.c"
component = "x"
[signals.jerked]
kind = "acceleration"
at = "load.c"
component = "x"
[signals.drive]
kind = "reaction"
joint = "rail"
quantity = "force"
axes = "joint"
component = "z"
"""
)

ARM = (
    "[ground.axis]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("hub", 1.0, 0.1, {"axis": (0, 0, 0), "rim": (0.2, 0, 0)})
    + rigid("rod", 3.0, 0.25, {"hinge": (-0.5, 0, 0), "end": (0.5, 0, 0)}, position=[0.7, 0.0, 0.0])
    + """
[joints.axis]
kind = "revolute"
between = ["ground.axis", "hub.axis"]
axis = [0.0, 0.0, 1.0]
drive = { speed = 20.0 }
[joints.lag]
kind = "revolute"
between = ["hub.rim", "rod.hinge"]
axis = [0.0, 0.0, 1.0]
[forces.push]
kind = "force"
at = "rod.end"
direction = [0.0, 1.0, 0.0]
frame = "following"
law = { table = { times = [0.0, 0.1, 0.2, 5.0], values = [0.0, 1e-3, 0.0, 0.0], interpolation = "linear" } }
[signals.lag]
kind = "joint"
joint = "lag"
coordinate = "angle"
"""  # noqa: E501
)


def exported(folder, text, *options):
    """Contents of linear.npz and rows of response.csv."""
    file = write_case_text(folder, text)
    out = folder / "out"
    arguments = ["modes", str(file), "--shapes", "0", "--out", str(out), *options]
    assert main(arguments) == 0
    return np.load(out / "linear.npz"), out


def responses(out):
    with (out / "response.csv").open() as file:
        rows = list(csv.reader(file))
    values = np.array(rows[1:], dtype=float)
    return rows[0], values[:, 0], values[:, 1::2] * np.exp(1j * np.radians(values[:, 2::2]))


def test_a_load_by_an_expression_of_the_time_is_an_input(tmp_path):
    """Two masses in a row, loads on the first: (K + s C + s^2 M) x = (1, 0); one that reads the
    motion is feedback, not an input."""
    text = (
        "[ground.wall]\nposition = [0.0, 0.0, 0.0]\n"
        + rigid("one", 2.0, 0.1, {"c": (0, 0, 0)})
        + rigid("two", 1.0, 0.1, {"c": (0, 0, 0)}, position=[1.0, 0.0, 0.0])
        + """
[joints.first]
kind = "prismatic"
between = ["ground.wall", "one.c"]
axis = [1.0, 0.0, 0.0]
[joints.second]
kind = "prismatic"
between = ["one.c", "two.c"]
axis = [1.0, 0.0, 0.0]
[forces.push]
kind = "force"
at = "one.c"
direction = [1.0, 0.0, 0.0]
law = { expression = "100 * step(t - 0.1) * sin(30 * t)" }
[forces.hold]
kind = "force"
at = "one.c"
direction = [1.0, 0.0, 0.0]
law = { expression = "-800 * joint('first') - 3 * joint_rate('first')" }
[forces.link]
kind = "coordinate_force"
joint = "second"
expression = "-500 * x - v"
[signals.two]
kind = "position"
at = "two.c"
component = "x"
"""
    )
    found, out = exported(tmp_path, text, "--response", "0.5:20")
    assert list(found["inputs"]) == ["push"]
    _, hz, G = responses(out)
    s = 2j * np.pi * hz
    link, hold = 500.0 + s, 800.0 + 3.0 * s
    expected = link / ((2.0 * s**2 + hold + link) * (s**2 + link) - link**2)
    np.testing.assert_allclose(G[:, 0], expected, rtol=1e-8)


def test_torque_on_a_pendulum(tmp_path):
    found, out = exported(tmp_path, PENDULUM, "--at", "equilibrium", "--response", "0.05:20")
    head, hz, G = responses(out)
    assert head[1] == "pin -> angle [rad / (N m)]"
    s = 2j * np.pi * hz
    J = 0.1 + 2.0 * 0.25
    expected = 1.0 / (J * s**2 + 0.3 * s + 2.0 * 9.81 * 0.5)
    np.testing.assert_allclose(G[:, 0], expected, rtol=1e-9)
    # the pin pushes the rod's centre sideways: m a = F, with the sign of the first side
    np.testing.assert_allclose(np.abs(G[:, 1]), np.abs(2.0 * 0.5 * s**2 * expected), rtol=1e-8)
    assert list(found["inputs"]) == ["pin"]
    assert list(found["input_units"]) == ["N m"]
    assert list(found["output_units"]) == ["rad", "N"]


def test_drive_enters_by_its_acceleration(tmp_path):
    found, out = exported(tmp_path, SLIDE, "--response", "0.1:10")
    assert list(found["inputs"]) == ["rail:drive"]
    assert list(found["states"])[-2:] == ["rail:drive", "rate of rail:drive"]
    _, hz, G = responses(out)
    s = 2j * np.pi * hz
    place = (1.5 * s + 80.0) / (2.0 * s**2 + 1.5 * s + 80.0) / s**2
    np.testing.assert_allclose(G[:, 0], place, rtol=1e-8)
    np.testing.assert_allclose(G[:, 1], s**2 * place, rtol=1e-8)
    np.testing.assert_allclose(np.abs(G[:, 2]), np.abs(1.0 + 2.0 * s**2 * place), rtol=1e-8)


def test_scipy_takes_the_matrices_as_they_are(tmp_path):
    from scipy.signal import StateSpace  # takes long to load

    found, _ = exported(tmp_path, SLIDE)
    system = StateSpace(found["A"], found["B"], found["C"], found["D"])
    expected = [*np.roots([2.0, 1.5, 80.0]), 0.0, 0.0]
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(system.A)), np.sort_complex(np.array(expected)), atol=1e-7
    )


def test_python_control_takes_the_matrices_and_names(tmp_path):
    control = pytest.importorskip("control")
    f, _ = exported(tmp_path, SLIDE)
    system = control.ss(
        f["A"], f["B"], f["C"], f["D"],
        states=list(f["states"]), inputs=list(f["inputs"]), outputs=list(f["outputs"]),
    )  # fmt: skip
    G = system(2.0j)[0, 0]
    s = 2.0j
    assert pytest.approx((1.5 * s + 80.0) / (2.0 * s**2 + 1.5 * s + 80.0) / s**2) == G


def test_matlab_file_has_the_same(tmp_path):
    found, out = exported(tmp_path, PENDULUM, "--at", "equilibrium")
    mat = loadmat(out / "linear.mat", chars_as_strings=True, simplify_cells=True)
    for key in "ABCD":
        np.testing.assert_array_equal(np.reshape(mat[key], found[key].shape), found[key])
    assert list(mat["outputs"]) == ["angle", "push"]
    assert str(mat["inputs"]) == "pin"


def test_linear_answer_of_a_spinning_arm_is_that_of_the_run(tmp_path):
    """A small push in steady spin: the state space, integrated by SciPy, against a run."""
    from scipy.signal import StateSpace, lsim

    found, _ = exported(tmp_path, ARM, "--at", "spin=20")
    push = list(found["inputs"]).index("push")
    file = tmp_path / "run" / "case.toml"
    file.parent.mkdir()
    steady = 'start = "equilibrium"\nspin = { axis = [0.0, 0.0, 1.0], speed = 20.0 }\n'
    result, _ = computed_file(file, HEAD + ARM + SOLVER.format(t_end=1.0, step=0.005, more=steady))
    lag = next(s.values for s in result.signals if s.name == "lag")
    size = np.interp(result.t, [0.0, 0.1, 0.2, 5.0], [0.0, 1e-3, 0.0, 0.0])
    system = StateSpace(found["A"], found["B"][:, [push]], found["C"], found["D"][:, [push]])
    _, expected, _ = lsim(system, size, result.t)
    np.testing.assert_allclose(lag, expected.ravel(), atol=1e-6 * np.abs(lag).max())


def test_controlled_pendulum_has_the_states_of_its_controller(tmp_path):
    """J s^2 + m g c + kp + ki / s + kd s / (Tf s + 1) = 0, about the hanging position."""
    text = PENDULUM + (
        '[forces.pid]\nkind = "controller"\njoint = "pin"\nsetpoint = "0"\n'
        "proportional = 30.0\nintegral = 12.0\nderivative = 4.0\nfilter_time = 0.05\n"
    )
    found, _ = exported(tmp_path, text, "--at", "equilibrium")
    J, d, k = 0.1 + 2.0 * 0.25, 0.3, 2.0 * 9.81 * 0.5
    lag = [0.05, 1.0]
    plant = np.polymul(np.polymul([J, d, k + 30.0], [1.0, 0.0]), lag)
    integral, damping = np.polymul([12.0], lag), [4.0, 0.0, 0.0]
    expected = np.roots(np.polyadd(np.polyadd(plant, integral), damping))
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(found["A"])), np.sort_complex(expected), rtol=1e-8
    )
    assert set(found["states"][2:]) == {"pid.integral_part", "pid.filtered"}
