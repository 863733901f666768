"""A run in the hands of another program: inputs between communication points, outputs there."""

from pathlib import Path

import numpy as np
import pytest
from samples.case_samples import HEAD, SOLVER, case_runs, rigid

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.math.arrays import Array
from plymotion.solver.run.coupled import Course, Stepper
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.studies.sensitivities.differentiated_run import step_derivatives

CARRIAGE = (
    rigid("box", 2.0, 0.1, {"c": [0, 0, 0]}, position=[0.5, 0, 0])
    + """
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.rail]
kind = "prismatic"
between = ["ground.o", "box.c"]
axis = [1.0, 0.0, 0.0]
DRIVE
[forces.push]
kind = "force"
at = "box.c"
direction = [1.0, 0.0, 0.0]
law = { constant = 3.0 }
[forces.link]
kind = "spring"
between = ["ground.o", "box.c"]
damping = 0.5
actuator = { expression = "0.1 * sin(t)" }
[signals.x]
kind = "position"
at = "box.c"
component = "x"
[signals.a]
kind = "acceleration"
at = "box.c"
component = "x"
"""
)
DRIVE = "drive = { polynomial = [0.0, 0.2, 9.0] }"
WRITTEN = ["joints.rail.drive", "forces.push"]  # the other inputs follow the case


def advanced(stepper: Stepper, t: float, values: np.ndarray) -> np.ndarray:
    """Move on to t [s] and return the outputs there, (n,)."""
    stepper.move(t, values)
    return stepper.measured()


def spec_of(folder: Path, text: str, more: str = "") -> RunSpec:
    """The only run of a case."""
    file = folder / "case.toml"
    file.write_text(HEAD + text + SOLVER.format(t_end=1.0, step=0.01, more=more))
    write_case(load_case(file), folder / "build")
    return read_run(folder / "build/runs/base.json")


def driven(t: Array) -> Array:
    """Value of a curve with all derivatives."""
    return np.asarray(0.2 * t + np.sin(3.0 * t) ** 2)


@pytest.mark.parametrize("drive", [True, False])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_course_repeats_polynomials_of_its_order(order: int, drive: bool) -> None:
    """Once its past is one, whatever the steps; a drive needs a step to be on it."""
    c = np.array([0.7, -1.1, 0.4])[: order + 1]
    start = np.zeros(3)
    start[: order + 1] = c * np.array([1.0, 1.0, 2.0])[: order + 1]
    course = Course(start, drive=drive, order=order)
    t, none = 0.0, np.full(2, np.nan)
    for h in (0.1, 0.03, 0.05, 0.2):
        piece = course.piece(t, h, float(np.polyval(c[::-1], t)), none)
        for s in np.linspace(0.0, h, 4):
            expected = np.polyval(c[::-1], t + s)
            assert np.polyval(piece[::-1], s) == pytest.approx(expected, abs=1e-13)
        t += h


def test_a_drive_has_two_continuous_derivatives() -> None:
    course, t, h = Course(np.zeros(3), drive=True, order=2), 0.0, 0.01
    end = np.zeros(3)
    values = np.random.default_rng(3).normal(size=8)  # the roughest of inputs
    for value in values:
        p = np.polynomial.Polynomial(course.piece(t, h, float(value), np.full(2, np.nan)))
        size = [np.abs(p.deriv(k)(np.linspace(0.0, h, 9))).max() for k in range(3)]
        for k in range(3):
            assert abs(p.deriv(k)(0.0) - end[k]) < 1e-12 * size[k]
        end = np.array([p.deriv(k)(h) for k in range(3)])
        t += h


def test_derivatives_that_are_known_are_used() -> None:
    """The slope of an input at t, and with it the error falls by an order."""
    t, h = 0.0, 0.01
    course = Course(np.array([0.0, 0.2, 18.0]), drive=True, order=2)
    for _ in range(50):
        rates = np.array([0.2 + 3.0 * np.sin(6.0 * t), 18.0 * np.cos(6.0 * t)])
        piece = course.piece(t, h, float(driven(np.array(t))), rates)
        t += h
        # third derivative of sin(3 t)^2 is 108 at most
        assert abs(np.polyval(piece[::-1], h) - driven(np.array(t))) < 108.0 * h**3 / 6.0


def test_drive_and_forces_are_inputs_by_their_keys(tmp_path: Path) -> None:
    """An expression of the time alone is a law; one that reads the motion is no input."""
    text = CARRIAGE.replace("DRIVE", DRIVE)
    drive, force = ("joints.rail.drive", "m", True), ("forces.push", "N", False)
    of_time, of_motion = "0.1 * sin(t)", "0.1 * sin(position('box.c', 'x'))"
    for expression, more in ((of_time, [("forces.link", "N", False)]), (of_motion, [])):
        spec = spec_of(tmp_path, text.replace(of_time, expression))
        stepper = Stepper(spec)
        found = [(given.name, given.unit, given.drive) for given in stepper.inputs]
        assert found == [drive, force, *more]
    assert stepper.inputs[0].start == pytest.approx([0.0, 0.2, 18.0])
    assert stepper.inputs[1].start == pytest.approx([3.0, 0.0, 0.0])


def test_a_driven_place_goes_where_the_input_says(tmp_path: Path) -> None:
    """Displacements count from the given start, whatever the input is at t = 0."""
    stepper = Stepper(spec_of(tmp_path, CARRIAGE.replace("DRIVE", DRIVE)), WRITTEN)
    assert stepper.start()[0] == pytest.approx(0.5, abs=1e-12)
    assert stepper.start(np.array([0.25, 0.0]))[0] == pytest.approx(0.75, abs=1e-12)
    stepper.start()
    h, gap = 1e-3, 0.0
    for k in range(300):
        t = np.array([k * h, (k + 1) * h])
        x, _ = advanced(stepper, t[1], np.array([driven(t)[0], 0.0]))
        gap = max(gap, abs(x - 0.5 - driven(t)[1]))
    assert 1e-9 < gap < 200.0 * h**3


# Held, a force is late by h / 2: h / 2 (F(t) - F(0)) / m in speed. Carried on by a line, it is
# wrong by 5 / 12 h^2 F'': 1e-5 m in 1 s.
@pytest.mark.parametrize(("order", "least", "most"), [(0, 1e-4, 2e-3), (1, 1e-8, 1e-5)])
def test_a_force_moves_a_mass(tmp_path: Path, order: int, least: float, most: float) -> None:
    """m x'' = 4 cos(5 t) - c x' + 0.1 sin(t) against the run that has the law itself."""
    text = CARRIAGE.replace("DRIVE", "")
    own = text.replace("constant = 3.0", 'expression = "4 * cos(5 * t)"')
    result, _ = execute(spec_of(tmp_path, own), progress=False)
    stepper = Stepper(spec_of(tmp_path, text), WRITTEN[1:])
    stepper.start(np.array([4.0]), force_order=order)
    h = 1e-3
    rows = [
        advanced(stepper, (k + 1) * h, np.array([4.0 * np.cos(5.0 * k * h)]))[0]
        for k in range(1000)
    ]
    gap = np.abs(np.array(rows)[9::10] - result.signals[0].values[1:]).max()
    assert least < gap < most


def test_laws_that_are_no_inputs_are_those_of_the_case(tmp_path: Path) -> None:
    spec = spec_of(tmp_path, CARRIAGE.replace("DRIVE", DRIVE))
    result, _ = execute(spec, progress=False)
    stepper = Stepper(spec, [])
    rows = [stepper.start()] + [advanced(stepper, float(t), np.zeros(0)) for t in result.t[1:]]
    for k, signal in enumerate(result.signals):
        assert np.array(rows)[:, k] == pytest.approx(signal.values, abs=1e-9)


@pytest.mark.parametrize("step", [1e-3, 0.7e-3])
def test_sampled_controllers_act_once_at_each_instant(
    repository: Path, tmp_path: Path, step: float
) -> None:
    """The robot arm: PID controllers of 1 ms with memory, at communication points or between."""
    spec = read_run(next(case_runs(repository, "controlled-arm", tmp_path).glob("*.json")))
    changes = {"t_end": 0.021, "output_step": step, "rtol": 1e-8}
    spec = spec.changed({f"solver.{key}": value for key, value in changes.items()})
    result, _ = execute(spec, progress=False)
    stepper = Stepper(spec)
    assert stepper.inputs == []
    rows = [stepper.start()] + [advanced(stepper, float(t), np.zeros(0)) for t in result.t[1:]]
    for k, name in enumerate(stepper.outputs):
        own = next(signal.values for signal in result.signals if signal.name == name)
        size = float(np.abs(own).max())
        assert np.abs(np.array(rows)[:, k] - own).max() < 2e-5 * size, name


def test_a_second_start_repeats_the_first(tmp_path: Path) -> None:
    stepper = Stepper(spec_of(tmp_path, CARRIAGE.replace("DRIVE", "")), WRITTEN[1:])

    def moved() -> Array:
        stepper.start(np.array([1.0]))
        return np.array([advanced(stepper, 0.01 * k, np.array([k % 3])) for k in range(1, 20)])

    assert np.array_equal(moved(), moved())


def test_derivatives_of_a_short_step(tmp_path: Path) -> None:
    """x = F / c (t - m / c (1 - exp(-c t / m))): its derivative is 1e-11 of x, velocities grow."""
    spec = spec_of(tmp_path, CARRIAGE.replace("DRIVE", ""))
    spec = spec.changed({"solver.integrator": "radau"})
    stepper = Stepper(spec, WRITTEN[1:], retraces=True)
    stepper.start(np.array([1.0]), force_order=0)
    h, c, m = 1e-5, 0.5, 2.0
    advanced(stepper, h, np.array([1.0]))
    x, a = step_derivatives(stepper)[:, 0]
    assert x == pytest.approx(h**2 / (2.0 * m) * (1.0 - c * h / (3.0 * m)), rel=1e-10, abs=0.0)
    assert a == pytest.approx(np.exp(-c * h / m) / m, rel=1e-10)


def test_refusals(tmp_path: Path) -> None:
    spec = spec_of(tmp_path, CARRIAGE.replace("DRIVE", DRIVE))
    with pytest.raises(InputError, match=r"forces\.pull: no such input; .*rail\.drive, forces\.pu"):
        Stepper(spec, ["forces.pull"])
    gear = spec.changed({"solver.integrator": "gear"})
    with pytest.raises(InputError, match=r'"gear": goes on from earlier .*"radau" or "rk8" or'):
        Stepper(gear)
