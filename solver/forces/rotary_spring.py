"""Rotary spring, damper and actuator about the z axis of marker one."""

import numpy as np

from ..bodies.marker import Marker
from ..compiled import jit
from ..rotations import cross, dot
from .wrench import Wrench, no_vector


@jit
def rotary_spring(
    one: Marker, two: Marker, stiffness: float, damping: float, angle: float, actuator: float
) -> Wrench:
    """The moment -k (phi - phi0) - c phidot + f about z turns marker two against marker one.

    phi is the angle from x of marker one to x of marker two about z, from -pi to pi [rad]: the
    spring has a jump half a turn away from its rest. `actuator` is f at the present time [N m].
    """
    x, y, arm = one.A[:, 0].copy(), one.A[:, 1].copy(), two.A[:, 0].copy()
    u, v = dot(x, arm), dot(y, arm)
    phi = np.arctan2(v, u) - angle
    phi -= 2.0 * np.pi * np.round(phi / (2.0 * np.pi))
    # phidot = n . (w_2 - w_1); n = z where both markers share it, as in a hinge
    n = (u * cross(arm, y) - v * cross(arm, x)) / (u * u + v * v)
    speed = dot(n, two.w - one.w)
    other = actuator - damping * speed
    moment = n * (other - stiffness * phi)
    return Wrench(no_vector(), moment, 0.5 * stiffness * phi * phi, other * speed)
