"""Universal joint: a common point and two crossing axes at right angles; four rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import ANGLE, Angle, Direction, Joint
from .rows import fixed_axes, same_point


@jit
def universal(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+3: same origin; z of marker one orthogonal to x of marker two.

    Marker one turns about its z, marker two about its x: the arms of the cross.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    same_point(rows, k, one, two)
    fixed_axes(rows, k + 3, one, two, 2, 0)


ANGLE_2 = Angle("angle_2", "angle_2 [rad] about `axis_2` of a universal", 2, 2, 1, 2)
JOINT = Joint(
    kind="universal",
    meaning="a common point and a cross with two axes",
    rows=universal,
    units="dddr",
    removes=("x", "y", "z"),
    keys=(
        Direction("axis", "arm of the cross in the first place, at the start, global"),
        Direction("axis_2", "arm in the second place, at a right angle to `axis`", required=True),
    ),
    coordinates=(ANGLE, ANGLE_2),
    order=4,
)
