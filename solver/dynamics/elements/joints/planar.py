"""Planar joint: motion in the plane normal to z, and rotation about z; three rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import ANGLE, Direction, DrivenBy, Joint, X, Y
from .rotation_drive import ROTATION_DRIVE
from .rows import along_axis, parallel_z


@jit
def planar(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+2: origin of marker two in the x-y plane of marker one; z axes parallel.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    along_axis(rows, k, one, two, 2, 0.0, 0.0, 0.0)
    parallel_z(rows, k + 1, one, two)


JOINT = Joint(
    kind="planar",
    meaning="motion in a plane, rotation about its normal",
    rows=planar,
    units="drr",
    removes=("z", "about x", "about y"),
    keys=(
        Direction("axis", "normal of the plane at the start, global"),
        DrivenBy("drive", ROTATION_DRIVE, "prescribed rotation"),
    ),
    coordinates=(ANGLE, X, Y),
    order=7,
)
