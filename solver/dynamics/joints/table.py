"""The kinds of joints: their rows, and the branch that the step loop takes."""

from ...math.arrays import Array
from ...math.compiled import jit
from .cylindrical import ROWS as CYLINDRICAL
from .cylindrical import cylindrical
from .distance import ROWS as DISTANCE
from .distance import distance
from .fixed import ROWS as FIXED
from .fixed import fixed
from .planar import ROWS as PLANAR
from .planar import planar
from .point_on_line import ROWS as POINT_ON_LINE
from .point_on_line import point_on_line
from .prismatic import ROWS as PRISMATIC
from .prismatic import prismatic
from .revolute import ROWS as REVOLUTE
from .revolute import revolute
from .rotation_drive import ROWS as ROTATION_DRIVE
from .rotation_drive import rotation_drive
from .spherical import ROWS as SPHERICAL
from .spherical import spherical
from .translation_drive import ROWS as TRANSLATION_DRIVE
from .translation_drive import translation_drive
from .universal import ROWS as UNIVERSAL
from .universal import universal

# In the order of the branches of `joint_rows`. The unit of each row: d distance [m], r angle [rad].
ROWS = {
    "revolute": REVOLUTE,
    "fixed": FIXED,
    "rotation_drive": ROTATION_DRIVE,
    "translation_drive": TRANSLATION_DRIVE,
    "spherical": SPHERICAL,
    "universal": UNIVERSAL,
    "cylindrical": CYLINDRICAL,
    "prismatic": PRISMATIC,
    "planar": PLANAR,
    "point_on_line": POINT_ON_LINE,
    "distance": DISTANCE,
}
NAMES = tuple(ROWS)
KINDS = {name: number for number, name in enumerate(NAMES)}
DRIVES = ("rotation_drive", "translation_drive")


@jit
def joint_rows(
    rows: Array,
    k: int,
    kind: int,
    one: Array,
    two: Array,
    f: float,
    f_d: float,
    f_dd: float,
    length: float,
) -> None:
    """Fill the rows of one joint, beginning at row k.

    `f`, `f_d`, `f_dd` are a drive's law and its rates at the present time, `length` is the
    parameter of a distance [m]; other kinds take no notice of them.
    """
    if kind == 0:
        revolute(rows, k, one, two)
    elif kind == 1:
        fixed(rows, k, one, two)
    elif kind == 2:
        rotation_drive(rows, k, one, two, f, f_d, f_dd)
    elif kind == 3:
        translation_drive(rows, k, one, two, f, f_d, f_dd)
    elif kind == 4:
        spherical(rows, k, one, two)
    elif kind == 5:
        universal(rows, k, one, two)
    elif kind == 6:
        cylindrical(rows, k, one, two)
    elif kind == 7:
        prismatic(rows, k, one, two)
    elif kind == 8:
        planar(rows, k, one, two)
    elif kind == 9:
        point_on_line(rows, k, one, two)
    else:
        distance(rows, k, one, two, length)
