"""Spring, damper and actuator along the line between two points."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ....math.arrays import Array, Triple
from ....math.compiled import jit
from ....math.rotations import dot3, minus3, times3
from ...model.motion import place, velocity
from ...tolerances import NO_DIRECTION
from .contract import DAMPING, FORCE, STIFFNESS, Element, Number, OfTime, Wrench


@jit
def spring(one: Array, two: Array, parameters: Array, actuator: float) -> Wrench:
    """The force -k (s - s0) - c sdot + f pushes the points apart; s is their distance [m].

    `actuator` is f at the present time [N]. Points that coincide have no direction: no force.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : stiffness [N/m], damping [N s/m], length at rest [m]
    actuator : force at the present time [N]
    """
    stiffness, damping, length = parameters[0], parameters[1], parameters[2]
    d = minus3(place(two), place(one))
    s = np.sqrt(dot3(d, d))
    if s < NO_DIRECTION:
        return Wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5 * stiffness * length * length, 0.0)
    direction = times3(1.0 / s, d)
    speed = dot3(direction, minus3(velocity(two), velocity(one)))
    stretch = s - length
    other = actuator - damping * speed
    force = times3(other - stiffness * stretch, direction)
    return Wrench(force, (0.0, 0.0, 0.0), 0.5 * stiffness * stretch * stretch, other * speed)


@jit
def spring_rows(one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Row 0: along the spring. Rows 1 to 3: along global axes, of a spring of no length.

    Such a spring ties two points together and holds them in every direction. Another one has
    stiffness T / s across its line under a tension T, which is left out: joints that take the
    tension cancel it.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : stiffness [N/m], damping [N s/m], length at rest [m]
    rows : rows (MOST_ROWS, N_ELEMENT_ROW) for Newton's matrix, to fill
    """
    stiffness, damping, length = parameters[0], parameters[1], parameters[2]
    d = minus3(place(two), place(one))
    s = np.sqrt(dot3(d, d))
    for i in range(3):
        n = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        _fill(rows, 1 + i, n, stiffness, 0.0, stiffness * d[i])
    if s < NO_DIRECTION:
        _fill(rows, 0, d, 0.0, 0.0, 0.0)
        return
    n = times3(1.0 / s, d)
    k = stiffness if length > 0.0 else 0.0
    speed = dot3(n, minus3(velocity(two), velocity(one)))
    _fill(rows, 0, n, k, damping, k * (s - length) + damping * speed)


@jit
def _fill(rows: Array, i: int, n: Triple, stiffness: float, damping: float, force: float) -> None:
    """Row i: relative motion of the points along n."""
    for j in range(3):
        rows[i, j], rows[i, 6 + j] = -n[j], n[j]
        rows[i, 3 + j] = rows[i, 9 + j] = 0.0
    rows[i, STIFFNESS], rows[i, DAMPING], rows[i, FORCE] = stiffness, damping, force


def _rows_in_use(parameters: Sequence[float]) -> list[int]:
    stiffness, damping, length = parameters[:3]
    if length > 0.0:
        return [0] if stiffness or damping else []
    return [*([0] if damping else []), *([1, 2, 3] if stiffness else [])]


def with_length(values: Mapping[str, Any], shift: Array) -> Mapping[str, Any]:
    """Return the numbers with the distance at the given start [m] as an absent length."""
    length = values["length"]
    return {**values, "length": float(np.linalg.norm(shift)) if length is None else length}


ELEMENT = Element(
    kind="spring",
    turns=False,
    meaning="spring, damper and actuator between two places",
    keys=(
        Number("stiffness", "N/m", "k", default=0.0, least=0.0),
        Number("damping", "N s/m", "c", default=0.0, least=0.0),
        Number(
            "length",
            "m",
            "of the spring without force; absent: the distance in the given starting position",
            least=0.0,
        ),
        OfTime("actuator", "force [N] that pushes the places apart"),
    ),
    complete=with_length,
    acts_by=("stiffness", "damping", "actuator"),
    wrench=spring,
    rows=spring_rows,
    most_rows=4,
    rows_in_use=_rows_in_use,
    order=1,
    coil=True,
)
