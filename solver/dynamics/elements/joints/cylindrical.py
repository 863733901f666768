"""Cylindrical joint: a common z axis, along which and about which it moves; four rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import ANGLE, Direction, DrivenBy, Joint, Z
from .rotation_drive import ROTATION_DRIVE
from .rows import on_z_axis, parallel_z
from .translation_drive import TRANSLATION_DRIVE


@jit
def cylindrical(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+3: origin of marker two on the z axis of marker one; z axes parallel.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    on_z_axis(rows, k, one, two)
    parallel_z(rows, k + 2, one, two)


JOINT = Joint(
    kind="cylindrical",
    meaning="rotation about an axis, motion along it",
    rows=cylindrical,
    units="ddrr",
    removes=("x", "y", "about x", "about y"),
    keys=(
        Direction("axis", "axis at the start, global"),
        DrivenBy("rotation_drive", ROTATION_DRIVE, "prescribed rotation"),
        DrivenBy("translation_drive", TRANSLATION_DRIVE, "prescribed displacement"),
    ),
    coordinates=(ANGLE, Z),
    order=5,
)
