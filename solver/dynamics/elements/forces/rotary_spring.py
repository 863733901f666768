"""Rotary spring, damper and actuator about the z axis of marker one."""

from collections.abc import Sequence

import numpy as np

from ....math.arrays import Array, Triple
from ....math.compiled import jit
from ....math.rotations import cross3, dot3, minus3, times3
from ...model.motion import axis, spin
from .contract import DAMPING, FORCE, STIFFNESS, Direction, Element, Number, OfTime, Wrench


@jit
def rotary_spring(one: Array, two: Array, parameters: Array, actuator: float) -> Wrench:
    """The moment -k (phi - phi0) - c phidot + f about z turns marker two against marker one.

    phi is the angle from x of marker one to x of marker two about z, from -pi to pi [rad]: the
    spring has a jump half a turn away from its rest. `actuator` is f at the present time [N m].

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : stiffness [N m/rad], damping [N m s/rad], angle at rest [rad]
    actuator : moment at the present time [N m]
    """
    stiffness, damping, angle = parameters[0], parameters[1], parameters[2]
    phi, n = _angle(one, two, angle)
    speed = dot3(n, minus3(spin(two), spin(one)))
    other = actuator - damping * speed
    moment = times3(other - stiffness * phi, n)
    return Wrench((0.0, 0.0, 0.0), moment, 0.5 * stiffness * phi * phi, other * speed)


@jit
def _angle(one: Array, two: Array, angle: float) -> tuple[float, Triple]:
    """Return phi - angle, from -pi to pi [rad], and n with phidot = n . (w_2 - w_1).

    n = z where both markers share it, as in a hinge.
    """
    x, y, arm = axis(one, 0), axis(one, 1), axis(two, 0)
    u, v = dot3(x, arm), dot3(y, arm)
    n = minus3(times3(u, cross3(arm, y)), times3(v, cross3(arm, x)))
    phi = np.arctan2(v, u) - angle
    phi -= 2.0 * np.pi * np.round(phi / (2.0 * np.pi))
    return phi, times3(1.0 / (u * u + v * v), n)


@jit
def rotary_spring_rows(one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Row 0: the rate of the angle.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : stiffness [N m/rad], damping [N m s/rad], angle at rest [rad]
    rows : rows (MOST_ROWS, N_ELEMENT_ROW) for Newton's matrix, to fill
    """
    phi, n = _angle(one, two, parameters[2])
    for j in range(3):
        rows[0, j] = rows[0, 6 + j] = 0.0
        rows[0, 3 + j], rows[0, 9 + j] = -n[j], n[j]
    rows[0, STIFFNESS], rows[0, DAMPING] = parameters[0], parameters[1]
    speed = dot3(n, minus3(spin(two), spin(one)))
    rows[0, FORCE] = parameters[0] * phi + parameters[1] * speed


def _rows_in_use(parameters: Sequence[float]) -> list[int]:
    return [0] if parameters[0] or parameters[1] else []


ELEMENT = Element(
    kind="rotary_spring",
    meaning="spring, damper and actuator of a hinge",
    remark="Its moment is discontinuous half a turn away from the rest angle.",
    keys=(
        Direction("axis", "axis at the start, global"),
        Number("stiffness", "N m/rad", "k", default=0.0, least=0.0),
        Number("damping", "N m s/rad", "c", default=0.0, least=0.0),
        Number(
            "angle", "rad", "angle without moment, from the given starting position", default=0.0
        ),
        OfTime("actuator", "torque [N m] on the second place about the axis"),
    ),
    acts_by=("stiffness", "damping", "actuator"),
    wrench=rotary_spring,
    rows=rotary_spring_rows,
    most_rows=1,
    rows_in_use=_rows_in_use,
    order=2,
)
