"""Prismatic joint: motion along the common z axis only; five rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import Direction, DrivenBy, Joint, Z
from .rows import fixed_axes, on_z_axis, parallel_z
from .translation_drive import TRANSLATION_DRIVE


@jit
def prismatic(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+4: as cylindrical, and no rotation about z.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    on_z_axis(rows, k, one, two)
    parallel_z(rows, k + 2, one, two)
    fixed_axes(rows, k + 4, one, two, 0, 1)


JOINT = Joint(
    kind="prismatic",
    meaning="motion along an axis, no rotation",
    rows=prismatic,
    units="ddrrr",
    removes=("x", "y", "about x", "about y", "about z"),
    keys=(
        Direction("axis", "axis at the start, global"),
        DrivenBy("drive", TRANSLATION_DRIVE, "prescribed displacement"),
    ),
    coordinates=(Z,),
    order=6,
)
