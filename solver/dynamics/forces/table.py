"""The kinds of force elements, and the branches that the step loop takes."""

from collections.abc import Sequence

from ...math.arrays import Array
from ...math.compiled import jit
from . import bushing as bushing_file
from . import load as load_file
from . import rotary_spring as rotary_spring_file
from . import spring as spring_file
from .bushing import bushing, bushing_rows
from .contract import ForceKind, Wrench
from .load import force, torque
from .rotary_spring import rotary_spring, rotary_spring_rows
from .spring import spring, spring_rows

# In the order of the branches below; loads from outside come last.
FORCE_KINDS: tuple[ForceKind, ...] = (
    spring_file.KIND,
    rotary_spring_file.KIND,
    bushing_file.KIND,
    load_file.FORCE,
    load_file.TORQUE,
)
KINDS = {kind.name: number for number, kind in enumerate(FORCE_KINDS)}
FIRST_LOAD = next(n for n, kind in enumerate(FORCE_KINDS) if kind.from_outside)
N_PARAMETER = max(len(kind.parameters) for kind in FORCE_KINDS)
MOST_ROWS = max(kind.most_rows for kind in FORCE_KINDS)


@jit
def element_wrench(kind: int, one: Array, two: Array, parameters: Array, law: float) -> Wrench:
    """The wrench of one element; `law` is its actuator force, or the size of a load."""
    if kind == 0:
        return spring(one, two, parameters, law)
    if kind == 1:
        return rotary_spring(one, two, parameters, law)
    if kind == 2:
        return bushing(one, two, parameters, law)
    if kind == 3:
        return force(one, two, parameters, law)
    return torque(one, two, parameters, law)


@jit
def element_rows(kind: int, one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Fill the rows (MOST_ROWS, N_ELEMENT_ROW) of one element for Newton's matrix."""
    if kind == 0:
        spring_rows(one, two, parameters, rows)
    elif kind == 1:
        rotary_spring_rows(one, two, parameters, rows)
    elif kind == 2:
        bushing_rows(one, two, parameters, rows)


def rows_in_use(kind: str, parameters: Sequence[float]) -> list[int]:
    """Return which rows an element of these parameters has in Newton's matrix."""
    return FORCE_KINDS[KINDS[kind]].rows_in_use([*parameters, *[0.0] * N_PARAMETER])
