"""Bushing: springs and dampers on all six relative motions of two markers."""

from ...math.arrays import Array
from ...math.compiled import jit
from ...math.rotations import moment_of_gradient, vector_of
from ...math.triple import cross3, dot3, minus3, triple
from ..bodies.motion import axis, from_axes, in_axes, place, velocity
from ..bodies.motion import spin as spin_of
from .wrench import Wrench


@jit
def bushing(one: Array, two: Array, stiffness: Array, damping: Array) -> Wrench:
    """Forces against the place and rotation of marker two in the axes of marker one.

    `stiffness` and `damping` (6,): along x, y, z, about x, y, z [N/m, N m/rad; N s/m, N m s/rad].
    The rotation is taken as a vector theta up to half a turn; its moments T^-T k theta are those
    of the energy theta' k theta / 2, so that nothing is lost at large angles.
    """
    d = minus3(place(two), place(one))
    turning = spin_of(one)
    offset = in_axes(one, d)
    speed = in_axes(one, minus3(minus3(velocity(two), velocity(one)), cross3(turning, d)))
    x, y, z = in_axes(one, axis(two, 0)), in_axes(one, axis(two, 1)), in_axes(one, axis(two, 2))
    theta = vector_of(x, y, z)
    spin = in_axes(one, minus3(spin_of(two), turning))
    k, c = triple(stiffness[:3]), triple(damping[:3])
    k_t, c_t = triple(stiffness[3:]), triple(damping[3:])
    gradient = (k_t[0] * theta[0], k_t[1] * theta[1], k_t[2] * theta[2])
    t = moment_of_gradient(theta, gradient)
    force = (
        -k[0] * offset[0] - c[0] * speed[0],
        -k[1] * offset[1] - c[1] * speed[1],
        -k[2] * offset[2] - c[2] * speed[2],
    )
    lost = (c_t[0] * spin[0], c_t[1] * spin[1], c_t[2] * spin[2])
    moment = (-t[0] - lost[0], -t[1] - lost[1], -t[2] - lost[2])
    potential, power = 0.0, -dot3(spin, lost)
    for i in range(3):
        potential += 0.5 * stiffness[i] * offset[i] ** 2 + 0.5 * stiffness[3 + i] * theta[i] ** 2
        power -= damping[i] * speed[i] ** 2
    return Wrench(from_axes(one, force), from_axes(one, moment), potential, power)
