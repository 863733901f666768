"""Distance: two points stay a given length apart, like the ends of a massless rod; one row."""

from ..bodies.marker import Marker
from ..compiled import jit
from ..rotations import dot
from .rows import Rows

ROWS = "d"


@jit
def distance(rows: Rows, k: int, one: Marker, two: Marker, length: float) -> None:
    """Row k: (d.d - L^2) / 2 L = 0 with d from marker one to marker two [m].

    To first order the excess of the distance over L > 0; smooth, and without a square root.
    """
    d = two.x - one.x
    d_d = two.v - one.v
    rows.Phi[k] = (dot(d, d) - length * length) / (2.0 * length)
    rows.Phi_t[k] = 0.0
    gamma = -dot(d_d, d_d)
    for j in range(3):
        rows.C[k, j] = -d[j] / length
        rows.C[k, 3 + j] = 0.0
        rows.C[k, 6 + j] = d[j] / length
        rows.C[k, 9 + j] = 0.0
        gamma -= d[j] * (two.a[j] - one.a[j])
    rows.gamma[k] = gamma / length
