"""Fixed joint: two markers coincide; six rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import FREEDOMS, Joint
from .rows import fixed_axes, same_point


@jit
def fixed(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+5: same origin and parallel axes.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    same_point(rows, k, one, two)
    fixed_axes(rows, k + 3, one, two, 0, 1)
    fixed_axes(rows, k + 4, one, two, 1, 2)
    fixed_axes(rows, k + 5, one, two, 2, 0)


JOINT = Joint(
    kind="fixed",
    meaning="no relative motion",
    rows=fixed,
    units="dddrrr",
    removes=FREEDOMS,
    order=2,
)
