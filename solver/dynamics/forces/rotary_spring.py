"""Rotary spring, damper and actuator about the z axis of marker one."""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import jit
from ...math.triple import cross3, dot3, minus3, times3
from ..bodies.motion import axis, spin
from .wrench import Wrench


@jit
def rotary_spring(
    one: Array, two: Array, stiffness: float, damping: float, angle: float, actuator: float
) -> Wrench:
    """The moment -k (phi - phi0) - c phidot + f about z turns marker two against marker one.

    phi is the angle from x of marker one to x of marker two about z, from -pi to pi [rad]: the
    spring has a jump half a turn away from its rest. `actuator` is f at the present time [N m].
    """
    x, y, arm = axis(one, 0), axis(one, 1), axis(two, 0)
    u, v = dot3(x, arm), dot3(y, arm)
    phi = np.arctan2(v, u) - angle
    phi -= 2.0 * np.pi * np.round(phi / (2.0 * np.pi))
    # phidot = n . (w_2 - w_1); n = z where both markers share it, as in a hinge
    n = minus3(times3(u, cross3(arm, y)), times3(v, cross3(arm, x)))
    n = times3(1.0 / (u * u + v * v), n)
    speed = dot3(n, minus3(spin(two), spin(one)))
    other = actuator - damping * speed
    moment = times3(other - stiffness * phi, n)
    return Wrench((0.0, 0.0, 0.0), moment, 0.5 * stiffness * phi * phi, other * speed)
