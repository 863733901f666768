"""The kinds of force elements, and the branch that the step loop takes."""

from ...math.arrays import Array
from ...math.compiled import jit
from .bushing import bushing
from .load import force, torque
from .rotary_spring import rotary_spring
from .spring import spring
from .wrench import Wrench

# In the order of the branches of `element_wrench`; the names of what `parameters` holds.
PARAMETERS = {
    "spring": ("stiffness", "damping", "length"),
    "rotary_spring": ("stiffness", "damping", "angle"),
    "bushing": tuple(f"{word} {axis}" for word in ("stiffness", "damping") for axis in range(6)),
    "force": ("direction x", "direction y", "direction z"),
    "torque": ("direction x", "direction y", "direction z"),
}
KINDS = {name: number for number, name in enumerate(PARAMETERS)}
FIRST_LOAD = KINDS["force"]  # from here on: from outside, nothing acts back on marker one
N_PARAMETER = 12


@jit
def element_wrench(kind: int, one: Array, two: Array, parameters: Array, law: float) -> Wrench:
    """The wrench of one element; `law` is its actuator force, or the size of a load."""
    if kind == 0:
        return spring(one, two, parameters[0], parameters[1], parameters[2], law)
    if kind == 1:
        return rotary_spring(one, two, parameters[0], parameters[1], parameters[2], law)
    if kind == 2:
        return bushing(one, two, parameters[:6], parameters[6:12])
    if kind == 3:
        return force(one, two, parameters[:3], law)
    return torque(one, two, parameters[:3], law)
