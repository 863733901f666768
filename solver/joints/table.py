"""The kinds of joints: number of rows, and the branch that the step loop takes."""

from ..bodies.marker import Marker
from ..compiled import jit
from ..package.schema import Array
from . import fixed as _fixed
from . import revolute as _revolute
from . import rotation_drive as _rotation_drive
from .fixed import fixed
from .revolute import revolute
from .rotation_drive import rotation_drive
from .rows import Rows

REVOLUTE = 0
FIXED = 1
ROTATION_DRIVE = 2

KINDS = {"revolute": REVOLUTE, "fixed": FIXED, "rotation_drive": ROTATION_DRIVE}
N_ROW = {
    REVOLUTE: _revolute.N_ROW,
    FIXED: _fixed.N_ROW,
    ROTATION_DRIVE: _rotation_drive.N_ROW,
}
N_PARAMETER = 8  # enough for a polynomial of degree 7


@jit
def joint_rows(
    rows: Rows, k: int, kind: int, one: Marker, two: Marker, t: float, parameters: Array
) -> None:
    """Fill the rows of one joint, beginning at row k."""
    if kind == 0:
        revolute(rows, k, one, two)
    elif kind == 1:
        fixed(rows, k, one, two)
    else:
        rotation_drive(rows, k, one, two, t, parameters)
