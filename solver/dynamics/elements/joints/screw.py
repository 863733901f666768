"""Screw: rotation about the common z axis and motion along it in a fixed ratio; five rows."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....math.arrays import Array
from ....math.compiled import jit
from ....math.rotations import cross3, dot3, minus3, times3
from ...model.model import GAMMA, PHI, PHI_T
from ...model.motion import axis, place, spin, velocity
from .contract import ANGLE, Direction, DrivenBy, Joint, Number, Numbers, Z
from .rotation_drive import ROTATION_DRIVE, rotation_drive
from .rows import along_axis, on_z_axis, parallel_z


@jit
def screw(rows: Array, k: int, one: Array, two: Array, lead: float, start: float) -> None:
    """Rows k..k+4: as cylindrical, and sin(angle - f) = 0 with f = 2 pi (z - start) / lead.

    z is the place of marker two along the axis [m]. The last row is that of a rotation drive whose
    f depends on the markers: its rates by their velocities go into C. No branch of an arc tangent.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    lead : way along the axis for one turn [m]
    start : position along the axis at the start [m]
    """
    on_z_axis(rows, k, one, two)
    parallel_z(rows, k + 2, one, two)
    along_axis(rows, k + 4, one, two, 2, start, 0.0, 0.0)
    per = 2.0 * np.pi / lead
    f, f_dd = per * rows[k + 4, PHI], -per * rows[k + 4, GAMMA]
    z, y, x = axis(one, 2), axis(one, 1), axis(one, 0)
    d = minus3(place(two), place(one))
    turning = cross3(spin(one), z)
    f_d = per * (dot3(z, minus3(velocity(two), velocity(one))) + dot3(turning, d))
    rotation_drive(rows, k + 4, one, two, f, f_d, f_dd)
    a = minus3(times3(np.cos(f), y), times3(np.sin(f), x))
    weight = per * dot3(z, cross3(a, axis(two, 0)))
    arm = cross3(z, d)
    for j in range(3):
        rows[k + 4, j] -= weight * z[j]
        rows[k + 4, 3 + j] += weight * arm[j]
        rows[k + 4, 6 + j] += weight * z[j]
    rows[k + 4, PHI_T] = 0.0


def _from_start(values: Mapping[str, Any], shift: Array) -> Numbers:
    """Let the angle be 0 at the given starting position."""
    return {"lead": float(values["lead"]), "start": float(shift[2])}


JOINT = Joint(
    kind="screw",
    meaning="rotation about an axis, motion along it in a fixed ratio",
    rows=screw,
    units="ddrrr",
    removes=("x", "y", "about x", "about y"),
    keys=(
        Direction("axis", "axis at the start, global"),
        Number(
            "lead",
            "m",
            "displacement along the axis for one turn about it, not 0; negative: left-handed",
            required=True,
            not_zero=True,
        ),
        DrivenBy("drive", ROTATION_DRIVE, "prescribed rotation"),
    ),
    coordinates=(ANGLE, Z),
    complete=_from_start,
    derived=("start",),
    order=10,
)
