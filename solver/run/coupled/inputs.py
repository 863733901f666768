"""What another program can write: laws of drives, of loads and of actuators."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...dynamics.elements.forces.contract import OfTime
from ...dynamics.elements.forces.table import ELEMENTS, LOADS
from ...dynamics.elements.joints.contract import Displacement, DrivenBy
from ...dynamics.elements.joints.table import JOINTS
from ...dynamics.evaluation.laws import law_values
from ...dynamics.model.model import Model
from ...inputs.case.of_time import drives, is_along, is_load, law
from ...math.arrays import Array
from ...math.laws import N_COEFFICIENT
from ...mechanism import BuiltMechanism

if TYPE_CHECKING:
    from ...inputs.case.schema import Mechanism

NEVER = 1e300  # [s], beginning of pieces that are out of use


@dataclass(frozen=True)
class Input:
    """One law that is written from outside.

    Attributes
    ----------
    name : key of the case: "joints.hinge.drive", "forces.push"
    unit : rad, m, N or N m
    law : number of the law in the model
    offset : what the law of the model is above the value of the case [m]
    drive : whether it is a drive, which must not jump; otherwise a force or torque
    start : (3,) value, rate and acceleration of the law of the case at t = 0
    """

    name: str
    unit: str
    law: int
    offset: float
    drive: bool
    start: Array


def inputs_of(mechanism: "Mechanism", built: BuiltMechanism) -> list[Input]:
    """Return all drives, then all forces that have a law of time, in the order of the case.

    A force by an expression is part of the mechanism, and no input.
    """
    values = law_values(built.model, 0.0)
    return [*_drives(mechanism, built, values), *_forces(mechanism, built, values)]


def _drives(mechanism: "Mechanism", built: BuiltMechanism, values: Array) -> Iterator[Input]:
    for name, joint in mechanism.joints.items():
        by = {key.name: key.drive for key in JOINTS[joint.kind].keys if isinstance(key, DrivenBy)}
        its = built.joints[name]
        for row, key in zip(its.rows[1:], drives(joint), strict=True):
            coordinate, offset = by[key].coordinate, 0.0
            if isinstance(coordinate, Displacement):
                offset = float(its.shift[coordinate.axis])
            number = int(built.model.joint_law[row])
            start = values[number] - [offset, 0.0, 0.0]
            yield Input(f"joints.{name}.{key}", coordinate.unit, number, offset, True, start)


def _forces(mechanism: "Mechanism", built: BuiltMechanism, values: Array) -> Iterator[Input]:
    for k, (name, force) in enumerate(mechanism.forces.items()):
        number = int(built.model.force_law[k])
        if is_along(force) or law(force) is None or number < 0:
            continue
        meaning = LOADS[force.kind].meaning if is_load(force) else _actuator(force.kind)
        unit = "N m" if "[N m]" in meaning else "N"
        yield Input(f"forces.{name}", unit, number, 0.0, False, values[number])


def _actuator(kind: str) -> str:
    """Meaning of the law of an element, with its unit."""
    return next(key.meaning for key in ELEMENTS[kind].keys if isinstance(key, OfTime))


def shift_law(model: Model, number: int, by: float) -> None:
    """Add a constant to a law, in the arrays of the model; one by an expression becomes a parabola.

    What the law does later stays known to the scales of the run (dynamics/analysis/scales.py).
    """
    if model.quantities.law[number] >= 0:
        value, rate, acceleration = law_values(model, 0.0)[number]
        write_piece(model, number, 0.0, np.array([value, rate, 0.5 * acceleration]))
    model.law_coefficient[model.law_start[number] : model.law_start[number + 1], 0] += by


def write_piece(model: Model, number: int, t: float, coefficients: Array) -> None:
    """Let a law be a polynomial of the time after t [s], in the arrays of the model.

    coefficients : (k,) of ascending powers
    """
    first, end = int(model.law_start[number]), int(model.law_start[number + 1])
    model.quantities.law[number] = -1
    model.law_time[first + 1 : end] = NEVER
    model.law_time[first] = t
    model.law_coefficient[first] = 0.0
    model.law_coefficient[first, : min(len(coefficients), N_COEFFICIENT)] = coefficients
