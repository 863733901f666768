"""The force elements of this folder by name and number, and the call of their kernels."""

from collections.abc import Sequence

from ....math.arrays import Array
from ....math.catalogue import by_name, catalogue, dispatched
from ....math.compiled import jit
from . import __name__ as _package
from . import __path__ as _path
from .contract import CoordinateForce, Element, ForceElement, KernelForce, Load, OfTime, Wrench


def _place(element: ForceElement) -> tuple[bool, bool, bool, int, str]:
    """Elements with rows in Newton's matrix, those without, loads, others; each in their order."""
    without = not isinstance(element, Element) or element.rows is None
    other = isinstance(element, CoordinateForce)
    return other, isinstance(element, Load), without, element.order, element.kind


FORCES: dict[str, ForceElement] = by_name(
    [(e.kind, e) for e in sorted(catalogue(_package, _path, ForceElement), key=_place)],
    "force element",
)
ELEMENTS: dict[str, Element] = {k: e for k, e in FORCES.items() if isinstance(e, Element)}
LOADS: dict[str, Load] = {k: e for k, e in FORCES.items() if isinstance(e, Load)}
COORDINATE_FORCES: dict[str, CoordinateForce] = {
    k: e for k, e in FORCES.items() if isinstance(e, CoordinateForce)
}
_KERNELS = {k: e for k, e in FORCES.items() if isinstance(e, KernelForce)}

# A number holds within one process: models are built again in each.
KINDS = {kind: number for number, kind in enumerate(_KERNELS)}
FIRST_LOAD = len(ELEMENTS)
N_PARAMETER = max(len(Load.parameters), *(len(e.parameters) for e in ELEMENTS.values()))
MOST_ROWS = max(e.most_rows for e in ELEMENTS.values())


@jit
def no_rows(one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Leave an element out of Newton's matrix.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : numbers of the element, in the order of its keys
    rows : rows (MOST_ROWS, N_ELEMENT_ROW) for Newton's matrix, to fill
    """


_ROWS = [*(e.rows for e in ELEMENTS.values() if e.rows is not None), no_rows]


@jit
@dispatched("kind", [(e.wrench, ("one", "two", "parameters", "law")) for e in _KERNELS.values()])
def element_wrench(kind: int, one: Array, two: Array, parameters: Array, law: float) -> Wrench:
    """The wrench of one element; `law` is its actuator force, or the size of a load.

    Parameters
    ----------
    kind : number of the kind (table.py)
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : numbers of the element, in the order of its keys
    law : actuator force or size of a load at the present time [N, N m]
    """
    raise NotImplementedError  # dispatched


@jit
@dispatched("kind", [(rows, ("one", "two", "parameters", "rows")) for rows in _ROWS])
def element_rows(kind: int, one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Fill the rows (MOST_ROWS, N_ELEMENT_ROW) of one element for Newton's matrix.

    Parameters
    ----------
    kind : number of the kind (table.py)
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : numbers of the element, in the order of its keys
    rows : rows (MOST_ROWS, N_ELEMENT_ROW) for Newton's matrix, to fill
    """


def unit_of_law(kind: str) -> str:
    """Return the unit of the law of a load or actuator, which its meaning states in brackets."""
    if kind in LOADS:
        meaning = LOADS[kind].meaning
    else:
        meaning = next(key.meaning for key in ELEMENTS[kind].keys if isinstance(key, OfTime))
    return meaning.partition("[")[2].partition("]")[0]


def rows_in_use(kind: str, parameters: Sequence[float]) -> list[int]:
    """Return which rows an element of these parameters has in Newton's matrix."""
    if kind in LOADS:
        return []
    return ELEMENTS[kind].rows_in_use([*parameters, *[0.0] * N_PARAMETER])
