"""Revolute joint: a common point and a common z axis; five rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import ANGLE, Direction, DrivenBy, Joint
from .rotation_drive import ROTATION_DRIVE
from .rows import parallel_z, same_point


@jit
def revolute(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+4: same origin; z of marker two orthogonal to x and y of marker one.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    same_point(rows, k, one, two)
    parallel_z(rows, k + 3, one, two)


JOINT = Joint(
    kind="revolute",
    meaning="a hinge, one rotation",
    rows=revolute,
    units="dddrr",
    removes=("x", "y", "z", "about x", "about y"),
    keys=(
        Direction("axis", "hinge axis at the start, global"),
        DrivenBy("drive", ROTATION_DRIVE, "prescribed rotation"),
    ),
    coordinates=(ANGLE,),
    order=1,
)
