"""Point on a line: the origin of marker two moves along the z axis of marker one; two rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import Direction, DrivenBy, Joint, Z
from .rows import on_z_axis
from .translation_drive import TRANSLATION_DRIVE


@jit
def point_on_line(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k, k+1: origin of marker two on the z axis of marker one.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    on_z_axis(rows, k, one, two)


JOINT = Joint(
    kind="point_on_line",
    meaning="the second place on a line of the first",
    rows=point_on_line,
    units="dd",
    removes=("x", "y"),
    keys=(
        Direction("axis", "line through the first place at the start, global"),
        DrivenBy("drive", TRANSLATION_DRIVE, "prescribed displacement"),
    ),
    coordinates=(Z,),
    order=8,
)
