"""Drive: the place of marker two along the z axis of marker one is given in time; one row."""

from ....math.arrays import Array
from ....math.compiled import jit
from .contract import Drive, Z
from .rows import along_axis


@jit
def translation_drive(
    rows: Array, k: int, one: Array, two: Array, f: float, f_d: float, f_dd: float
) -> None:
    """Row k: origin of marker two at f along z of marker one, f and its rates of time [m, s].

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    f : position along the axis [m]
    f_d : its rate [m/s]
    f_dd : its second rate [m/s2]
    """
    along_axis(rows, k, one, two, 2, f, f_d, f_dd)


TRANSLATION_DRIVE = Drive(
    kind="translation_drive",
    rows=translation_drive,
    units="d",
    removes=("z",),
    coordinate=Z,
)
