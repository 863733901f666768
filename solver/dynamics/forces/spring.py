"""Spring, damper and actuator along the line between two points."""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import jit
from ...math.triple import dot3, minus3, times3
from ..bodies.motion import place, velocity
from .wrench import Wrench


@jit
def spring(
    one: Array, two: Array, stiffness: float, damping: float, length: float, actuator: float
) -> Wrench:
    """The force -k (s - s0) - c sdot + f pushes the points apart; s is their distance [m].

    `actuator` is f at the present time [N]. Points that coincide have no direction: no force.
    """
    d = minus3(place(two), place(one))
    s = np.sqrt(dot3(d, d))
    if s < 1e-12:
        return Wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5 * stiffness * length * length, 0.0)
    direction = times3(1.0 / s, d)
    speed = dot3(direction, minus3(velocity(two), velocity(one)))
    stretch = s - length
    other = actuator - damping * speed
    force = times3(other - stiffness * stretch, direction)
    return Wrench(force, (0.0, 0.0, 0.0), 0.5 * stiffness * stretch * stretch, other * speed)
