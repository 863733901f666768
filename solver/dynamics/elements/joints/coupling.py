"""Row of a coupling: coordinates of several pairs of markers; evaluation.py fills it.

It stands among the joints as one of a single row, between the markers of its first coordinate.
"""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import CouplingKind


@jit
def coupled_angles(rows: Array, k: int, one: Array, two: Array) -> None:
    """Leave row k as it is.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """


@jit
def coupled_lengths(rows: Array, k: int, one: Array, two: Array) -> None:
    """Leave row k as it is.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """


ANGLES = CouplingKind("coupled angles", coupled_angles, "r", ())
LENGTHS = CouplingKind("coupled lengths", coupled_lengths, "d", ())
