"""Bushing: springs and dampers on all six relative motions of two markers."""

import numpy as np

from ..bodies.marker import Marker
from ..compiled import jit
from ..package.schema import Array
from ..rotations import cross, dot, matrix_to_vector, tangent_map
from ..small import mm, mv, tv
from .wrench import Wrench


@jit
def bushing(one: Marker, two: Marker, stiffness: Array, damping: Array) -> Wrench:
    """Forces against the place and rotation of marker two in the axes of marker one.

    `stiffness` and `damping` (6,): along x, y, z, about x, y, z [N/m, N m/rad; N s/m, N m s/rad].
    The rotation is taken as a vector theta up to half a turn; its moments T^-T k theta are those
    of the energy theta' k theta / 2, so that nothing is lost at large angles.
    """
    d = two.x - one.x
    place = tv(one.A, d)
    speed = tv(one.A, two.v - one.v - cross(one.w, d))
    theta = matrix_to_vector(mm(one.A.T.copy(), two.A))
    spin = tv(one.A, two.w - one.w)
    elastic = np.linalg.solve(tangent_map(theta).T.copy(), stiffness[3:] * theta)
    force = -stiffness[:3] * place - damping[:3] * speed
    moment = -elastic - damping[3:] * spin
    potential = 0.5 * (dot(place, stiffness[:3] * place) + dot(theta, stiffness[3:] * theta))
    power = -dot(speed, damping[:3] * speed) - dot(spin, damping[3:] * spin)
    return Wrench(mv(one.A, force), mv(one.A, moment), potential, power)
