"""Spherical joint: a common point; three rows."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import Joint
from .rows import same_point


@jit
def spherical(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+2: same origin.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    same_point(rows, k, one, two)


JOINT = Joint(
    kind="spherical",
    meaning="a common point, three rotations",
    rows=spherical,
    units="ddd",
    removes=("x", "y", "z"),
    order=3,
)
