"""`pm.simulate`: steps, states to the last bit, equations and Jacobians against differences."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import plymotion as pm
from plymotion.solver.errors import InputError
from plymotion.solver.extras.robot.case_folder import import_robot

ROBOTS = Path(__file__).parents[1] / "samples/robots"
Made = Callable[[], pm.Simulation]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a rigid arm with a motor in each rotation and a signal of its tip."""
    out = tmp_path_factory.mktemp("robot")
    import_robot(ROBOTS / "arm.urdf", out, joints="motor", meshes=False)
    text = (out / "case.toml").read_text()
    for axis in "xyz":
        tip = f'at = "wrist.tip"\ncomponent = "{axis}"\n'
        text = text.replace("[solver]", f'[signals.{axis}]\nkind = "position"\n{tip}\n[solver]')
    (out / "case.toml").write_text(text)
    return out


@pytest.fixture
def arm(folder: Path) -> pm.Simulation:
    return pm.simulate(folder, out=folder / "build")


def moved(sim: pm.Simulation, count: int) -> None:
    for k in range(count):
        sim.step(1e-3, {"forces.shoulder_motor": 20.0 * np.sin(0.3 * k + sim.t)})


def test_states_to_the_last_bit(arm: pm.Simulation) -> None:
    """The same inputs from a kept state give the same bits, however often."""
    assert arm.inputs == ("forces.shoulder_motor", "forces.wrist_motor")
    moved(arm, 30)
    kept = arm.state
    found = []
    for _ in range(3):
        moved(arm, 25)
        found.append((arm.y, arm.signals["shoulder_q"], arm.t))
        arm.state = kept
    for y, angle, t in found[1:]:
        assert np.array_equal(y, found[0][0])
        assert (angle, t) == found[0][1:]
    arm.reset()
    moved(arm, 30)
    assert np.array_equal(arm.y, kept[0].y)


def test_steps_are_those_of_a_run(folder: Path, arm: pm.Simulation) -> None:
    """Steps of 1 ms and the run of the case agree to its accuracy."""
    result = pm.run(folder, out=folder / "build")
    for _ in range(200):
        arm.step(1e-3)
    for name in ("shoulder_q", "slide_q", "z"):
        assert arm.signals[name] == pytest.approx(result.signals[name].at(0.2), abs=2e-5)
    assert arm.warnings == []


@pytest.mark.parametrize("dt", [1e-18, 1e-16, 2e-15])
def test_steps_of_a_rounding_error(arm: pm.Simulation, dt: float) -> None:
    """What is left of an interval: below the spacing of numbers, or of the smallest step."""
    ends = []
    arm.step(0.05)
    state = arm.state
    for steps in ((0.01,), (dt, 0.01)):
        arm.state = state
        for each in steps:
            arm.step(each)
        ends.append(arm.q)
    assert np.abs(ends[1] - ends[0]).max() < 1e-6 * np.abs(ends[0]).max()


def test_equations_at_a_state(arm: pm.Simulation) -> None:
    """M qdd + c = 0 gives the accelerations of the motion; c has the torques of the motors."""
    arm.place([0.4, 0.1, -0.3], [0.5, -0.2, 1.0])
    assert np.abs(arm.q - [0.4, 0.1, -0.3]).max() < 1e-13
    assert np.abs(arm.qd - [0.5, -0.2, 1.0]).max() < 1e-13
    inputs, h = [3.0, 0.5], 1e-4
    arm.step(h, inputs)
    before = arm.qd
    arm.step(h, inputs)
    found = arm.equations()
    qdd = np.linalg.solve(found.M, -found.c)
    arm.step(h, inputs)
    slope = (arm.qd - before) / (2.0 * h)
    assert np.abs(slope - qdd).max() < 1e-4 * np.abs(qdd).max()


def test_places_have_the_turns_that_are_given(arm: pm.Simulation) -> None:
    """Stops count from the given angle: once they counted from where the arm had been before."""
    arm.place([-1.4])
    alone = arm.equations().c
    for angle in (1.9, -1.4 + 4.0 * np.pi, -1.4):
        arm.place([angle])
    assert np.array_equal(arm.equations().c, alone)
    arm.place([-1.4 + 2.0 * np.pi])
    stop = arm.equations().c[0] - alone[0]
    assert stop == pytest.approx(60.0 / 0.01 * (2.0 * np.pi - 1.4 - 2.0), rel=1e-10)


def test_places_that_drives_do_not_allow(folder: Path) -> None:
    """A drive once took the joint back within the next step, without a word."""
    case = pm.load(folder)
    case.joints.shoulder.drive = {"polynomial": [0.0]}
    sim = pm.simulate(case, out=folder / "build")
    sim.step(1e-3)
    before = sim.y
    with pytest.raises(
        InputError, match=r"^positions that .* gap in shoulder \(drive\): 0 m, 0.38"
    ):
        sim.place([0.4])
    with pytest.raises(
        InputError, match=r"^rates that .* gap in shoulder \(drive\): 0 m/s, 2 rad/s"
    ):
        sim.place([0.0], [2.0])
    assert sim.t == 1e-3
    assert np.array_equal(sim.y, before)
    sim.reset({"joints.shoulder.drive": 0.4})
    sim.place([0.4, 0.1])
    sim.step(1e-3)
    assert sim.q[:2] == pytest.approx([0.4, 0.1], abs=1e-4)


def test_jacobian_by_differences(arm: pm.Simulation) -> None:
    """Velocity of the tip by the rates, from places of displaced coordinates."""
    q, h = np.array([0.4, 0.1, -0.3]), 1e-5
    arm.place(q)
    J = arm.jacobian("wrist.tip")
    for k, e in enumerate(h * np.eye(3)):
        ends = []
        for side in (1.0, -1.0):
            arm.place(q + side * e)
            ends.append([arm.signals[axis] for axis in "xyz"])
        slope = np.subtract(*ends) / (2.0 * h)
        assert np.abs(J[:3, k] - slope).max() < 1e-9
    assert np.abs(J[3:, 1]).max() < 1e-14  # a slide does not turn


def test_what_is_refused(arm: pm.Simulation, folder: Path) -> None:
    """Unknown inputs and places, values that are none, states of another simulation."""
    with pytest.raises(pm.InputError, match=r"no input 'forces\.shoulder'; did you mean"):
        arm.step(1e-3, {"forces.shoulder": 1.0})
    with pytest.raises(pm.InputError, match=r"inputs: 1 values; expected 2, in the order forces"):
        arm.step(1e-3, [1.0])
    before = arm.y
    for wrong in ([np.nan, 0.0], ["1", "2"], [[1.0, 2.0]], [None, 0.0], [[1.0], 2.0], "12"):
        with pytest.raises(pm.InputError, match="expected finite numbers"):
            arm.step(1e-3, wrong)
        with pytest.raises(pm.InputError, match="expected finite numbers"):
            arm.place(wrong)
    for value, message in (("3", "finite numbers"), (None, "finite"), ([1.0, 2.0], "expected 1")):
        with pytest.raises(pm.InputError, match=rf"forces\.shoulder_motor.*{message}"):
            arm.step(1e-3, {"forces.shoulder_motor": value})
    assert np.array_equal(arm.y, before)
    for dt in (0.0, np.inf, np.nan, "0.01", None):
        with pytest.raises(pm.InputError, match=r"expected a time above 0"):
            arm.step(dt)
    with pytest.raises(pm.InputError, match=r"no place 'wrist\.top'; did you mean 'wrist\.tip'"):
        arm.jacobian("wrist.top")
    with pytest.raises(pm.InputError, match=r"place: 4 values; expected at most 3"):
        arm.place([0.0] * 4)
    with pytest.raises(KeyError, match="did you mean 'shoulder_q'"):
        arm.signals["shoulder"]
    other = pm.simulate(folder, out=folder / "build")
    with pytest.raises(pm.InputError, match="expected one of this simulation"):
        other.state = arm.state
    for state in (None, arm.y, arm.state[0]):
        with pytest.raises(pm.InputError, match="expected one of this simulation"):
            arm.state = state
    with pytest.raises(pm.InputError, match=r"fixed_step='a'\): expected a time above 0"):
        pm.simulate(folder, fixed_step="a")


def test_fixed_steps_converge_with_the_order_of_the_integrator(folder: Path) -> None:
    """A constant torque: the error of Radau IIA falls by 2^5 when the step is halved.

    Without friction, whose smoothed change of sign such steps do not see.
    """
    case = pm.load(folder).changed({"solver.rtol": 1e-11})
    forces = case.table["forces"]
    case.table["forces"] = {k: v for k, v in forces.items() if v["kind"] != "friction"}
    ends = []
    for h in (None, 0.01, 0.005):
        sim = pm.simulate(case, fixed_step=h, out=folder / "build")
        for _ in range(8):
            sim.step(0.01, {"forces.shoulder_motor": 15.0})
        ends.append(sim.y[:-1])
    errors = [float(np.abs(end - ends[0]).max()) for end in ends[1:]]
    assert 24.0 < errors[0] / errors[1] < 60.0
    with pytest.raises(InputError, match=r"fixed_step=0.0\): expected a time above 0"):
        pm.simulate(folder, fixed_step=0.0)


def tubes(repository: Path, motors: bool, **solver: float) -> pm.Case:
    """Return the arm of cases/robot-import for two laminated tubes, with motors or held."""
    case = pm.load(repository / "cases/robot-import/case.toml")
    for name, joint in case.table["joints"].items():
        joint["drive"] = {"speed": 0.0}
        if motors:
            del joint["drive"]
            actuator = {"constant": 0.0}
            case.rotary_spring(name, *joint["between"], axis=joint["axis"], actuator=actuator)
    case.table["figures"], case.table["variants"]["tubes"]["signals"] = {}, {}
    place = {"kind": "position", "at": "flange.tool"}
    case.table["signals"] = {axis: {**place, "component": axis} for axis in "xyz"}
    case.table["solver"] |= {"start": "positions", **solver}
    return case


@pytest.mark.parametrize(
    ("motors", "dt", "count", "most", "least"), [(True, 1e-3, 40, 4, 25), (False, 0.2, 8, 24, 30)]
)
def test_vibrations_are_followed_to_rtol_in_displacements(
    repository: Path, tmp_path: Path, motors: bool, dt: float, count: int, most: int, least: int
) -> None:
    """Rates of vibrations faster than the steps cost nothing; the arm falls, or swings 16 mm.

    With `cutoff_frequency = 0` they are resolved. The swing at 5.8 Hz is faster than steps of 0.2 s
    and goes on: its displacements are not small.
    """
    ready, ends, taken = repository / "tests/packages/robot-import", [], []
    for solver in ({"rtol": 1e-7, "cutoff_frequency": 0.0}, {"cutoff_frequency": 0.0}, {}):
        case = tubes(repository, motors, **solver)
        sim = pm.simulate(case, "tubes", out=tmp_path, packages=ready)
        path = []
        for k in range(count):
            torques = np.array([20, 20, 10, 0.2, 0.2, 0.02]) * np.sin(0.01 * k + np.arange(6))
            sim.step(dt, torques if motors else None)
            path.append(list(sim.signals.values()))
        ends.append(np.array(path))
        taken.append(sim._stepper._integrator.counters.steps / count)  # type: ignore[union-attr]
    size = np.ptp(ends[0], axis=0).max()
    errors = [np.abs(path - ends[0]).max() for path in ends]
    assert size > 4e-3
    assert errors[2] < 2e-5  # rtol is 1e-5, of an arm of 1.2 m
    assert taken[2] < most < least < taken[1]


def test_steps_behind_a_jump_take_few_iterations(repository: Path, tmp_path: Path) -> None:
    """Torques that are noise: the polynomial of a transient, continued, asked for 19.5 each."""
    case, ready = (
        tubes(repository, motors=True, rtol=1e-3),
        repository / "tests/packages/robot-import",
    )
    sim = pm.simulate(case, "tubes", out=tmp_path, packages=ready, fixed_step=5e-4)
    noise = np.random.default_rng(0).uniform(-1.0, 1.0, (30, 6))
    for torques in [20, 20, 10, 0.2, 0.2, 0.02] * noise:
        sim.step(1e-3, torques)
    counters = sim._stepper._integrator.counters  # type: ignore[union-attr]
    assert counters.evaluations < 18 * len(noise)


def test_the_accuracy_is_that_of_the_case_whatever_the_inputs_at_the_start(
    arm: pm.Simulation,
) -> None:
    """A large torque at a reset once made the tolerances as much looser."""
    counts = []
    for torque in (0.0, 1e4):
        arm.reset({"forces.shoulder_motor": torque})
        arm.step(1e-3, {"forces.shoulder_motor": 20.0})
        counts.append(arm._stepper._integrator._options.atol)  # type: ignore[union-attr]
    assert np.array_equal(*counts)


def test_a_kink_a_rounding_error_behind_a_step(tmp_path):
    """Ten steps of 0.02 s end at 0.2 s less one bit, where its law ends."""
    case = pm.Case("rail", solver={"t_end": 1.0, "output_step": 0.1})
    place = {"position": (0.0, 0.0, 0.0)}
    case.bodies["b"] = {"kind": "rigid", "mass": 1.0, "inertia": np.eye(3)}
    case.bodies["b"]["interfaces"] = {"c": place}
    case.ground["o"] = place
    case.joints["r"] = {"kind": "prismatic", "between": ["ground.o", "b.c"], "axis": (1, 0, 0)}
    push = {"kind": "force", "at": "b.c", "direction": (1, 0, 0)}
    push["law"] = {"smooth_step": {"value": 1.0, "duration": 0.2}}
    stop = {"kind": "limit_stop", "joint": "r", "upper": 9.0, "stiffness": 1.0, "restitution": 0.5}
    case.forces["push"], case.forces["stop"] = push, stop
    case.signals["x"] = {"kind": "position", "at": "b.c", "component": "x"}
    simulation = pm.simulate(case, out=tmp_path / "out")
    for _ in range(20):
        simulation.step(0.02, {"forces.push": 1.0})
    assert simulation.signals["x"] == pytest.approx(0.5 * 0.4**2, rel=1e-6)


@pytest.mark.parametrize("stopped", [True, False])
def test_a_sample_a_rounding_error_behind_a_step(tmp_path, stopped):
    """Ten steps of 0.01 s end at 0.1 s less one bit, where a controller samples.

    Between two calls of the loop beside a stop, else inside: there it was sampled twice, a step of
    one bit apart, and the next step was too small.
    """
    case = pm.Case("rail", solver={"t_end": 1.0, "output_step": 0.05, "rtol": 1e-8})
    case.point("o", (0, 0, 0))
    case.rigid("b", mass=1.0, inertia=np.eye(3), interfaces={"c": (0, 0, 0)})
    case.prismatic("r", "ground.o", "b.c", axis="x")
    if stopped:
        case.limit_stop("stop", joint="r", upper=9.0, stiffness=1.0, restitution=0.5)
    gains = {"proportional": 20.0, "integral": 50.0}
    case.controller("held", joint="r", setpoint="1", **gains, sample_time=0.005)
    case.signals["x"] = {"kind": "position", "at": "b.c", "component": "x"}
    whole = pm.run(case, out=tmp_path / "run")
    simulation = pm.simulate(case, out=tmp_path / "out")
    for _ in range(20):
        simulation.step(0.01)
    assert simulation.signals["x"] == pytest.approx(whole.signals["x"].at(0.2), rel=1e-6)
