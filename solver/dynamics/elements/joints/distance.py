"""Distance: two points stay a given length apart, like the ends of a massless rod; one row."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....errors import InputError
from ....math.arrays import Array
from ....math.compiled import jit
from ....math.rotations import dot3, minus3
from ...model.model import GAMMA, PHI, PHI_T
from ...model.motion import acceleration, place, velocity
from ...tolerances import LEAST_LENGTH
from .contract import Joint, Number, Numbers


@jit
def distance(rows: Array, k: int, one: Array, two: Array, length: float) -> None:
    """Row k: (d.d - L^2) / 2 L = 0 with d from marker one to marker two [m].

    To first order the excess of the distance over L > 0; smooth, and without a square root.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    length : distance L > 0 [m]
    """
    d = minus3(place(two), place(one))
    d_d = minus3(velocity(two), velocity(one))
    d_dd = minus3(acceleration(two), acceleration(one))
    rows[k, PHI] = (dot3(d, d) - length * length) / (2.0 * length)
    rows[k, PHI_T] = 0.0
    gamma = -dot3(d_d, d_d)
    for j in range(3):
        rows[k, j] = -d[j] / length
        rows[k, 3 + j] = 0.0
        rows[k, 6 + j] = d[j] / length
        rows[k, 9 + j] = 0.0
        gamma -= d[j] * d_dd[j]
    rows[k, GAMMA] = gamma / length


def length_of(values: Mapping[str, Any], shift: Array) -> Numbers:
    """Return the given length, else the distance at the given start [m]."""
    given = values["length"]
    length = float(np.linalg.norm(shift)) if given is None else float(given)
    if length < LEAST_LENGTH:
        raise InputError(
            f": its places {values['between']} coincide at the start; expected a `length`, or a "
            "spherical joint"
        )
    return {"length": length}


JOINT = Joint(
    kind="distance",
    meaning="two places a fixed length apart, a massless rod",
    rows=distance,
    units="d",
    removes=(),
    keys=(Number("length", "m", "absent: the distance in the given starting position", above=0.0),),
    complete=length_of,
    order=9,
)
