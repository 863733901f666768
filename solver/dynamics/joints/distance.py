"""Distance: two points stay a given length apart, like the ends of a massless rod; one row."""

from ...math.arrays import Array
from ...math.compiled import jit
from ...math.triple import dot3, minus3
from ..bodies.motion import acceleration, place, velocity
from ..workspace import GAMMA, PHI, PHI_T

ROWS = "d"


@jit
def distance(rows: Array, k: int, one: Array, two: Array, length: float) -> None:
    """Row k: (d.d - L^2) / 2 L = 0 with d from marker one to marker two [m].

    To first order the excess of the distance over L > 0; smooth, and without a square root.
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
