"""Force or torque from outside on marker two, its direction fixed in the axes of marker one."""

from ....math.arrays import Array
from ....math.compiled import jit
from ....math.rotations import dot3, times3, triple
from ...model.motion import from_axes, spin, velocity
from .contract import Load, Wrench


@jit
def force(one: Array, two: Array, parameters: Array, size: float) -> Wrench:
    """`size` [N] along parameters[:3]: global if marker one is of the ground, else following.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : direction (3,) of unit length in the axes of marker one
    size : force [N]
    """
    load = times3(size, from_axes(one, triple(parameters[:3])))
    return Wrench(load, (0.0, 0.0, 0.0), 0.0, dot3(load, velocity(two)))


@jit
def torque(one: Array, two: Array, parameters: Array, size: float) -> Wrench:
    """`size` [N m] about parameters[:3], as in `force`.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : direction (3,) of unit length in the axes of marker one
    size : moment [N m]
    """
    load = times3(size, from_axes(one, triple(parameters[:3])))
    return Wrench((0.0, 0.0, 0.0), load, 0.0, dot3(load, spin(two)))


FORCE = Load(kind="force", turns=False, meaning="a force [N] from outside", wrench=force, order=1)
TORQUE = Load(kind="torque", meaning="a torque [N m] from outside", wrench=torque, order=2)
