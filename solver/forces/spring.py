"""Spring, damper and actuator along the line between two points."""

import numpy as np

from ..bodies.marker import Marker
from ..compiled import jit
from ..rotations import dot
from .wrench import Wrench, no_vector


@jit
def spring(
    one: Marker, two: Marker, stiffness: float, damping: float, length: float, actuator: float
) -> Wrench:
    """The force -k (s - s0) - c sdot + f pushes the points apart; s is their distance [m].

    `actuator` is f at the present time [N]. Points that coincide have no direction: no force.
    """
    d = two.x - one.x
    s = np.sqrt(dot(d, d))
    if s < 1e-12:
        return Wrench(no_vector(), no_vector(), 0.5 * stiffness * length * length, 0.0)
    direction = d / s
    speed = dot(direction, two.v - one.v)
    stretch = s - length
    other = actuator - damping * speed
    force = direction * (other - stiffness * stretch)
    return Wrench(force, no_vector(), 0.5 * stiffness * stretch * stretch, other * speed)
