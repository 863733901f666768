"""Force or torque from outside on marker two, its direction fixed in the axes of marker one."""

from ..bodies.marker import Marker
from ..compiled import jit
from ..package.schema import Array
from ..rotations import dot
from ..small import mv
from .wrench import Wrench, no_vector


@jit
def force(one: Marker, two: Marker, direction: Array, size: float) -> Wrench:
    """`size` [N] along `direction` (3,): global if marker one is of the ground, else following."""
    load = size * mv(one.A, direction)
    return Wrench(load, no_vector(), 0.0, dot(load, two.v))


@jit
def torque(one: Marker, two: Marker, direction: Array, size: float) -> Wrench:
    """`size` [N m] about `direction` (3,), as in `force`."""
    load = size * mv(one.A, direction)
    return Wrench(no_vector(), load, 0.0, dot(load, two.w))
