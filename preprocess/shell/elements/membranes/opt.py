"""OPT: the optimal membrane triangle with drilling rotations (Felippa 2003)."""

import numpy as np
from ufl import as_matrix, as_vector

from .....solver.math.arrays import Array
from ..cell import Cell
from .contract import Membrane, MembraneStrains, linear_strain

ALPHA_B = 1.5
LOWEST = 0.01  # lower bound of beta0

# Strains along sides 1-2, 2-3, 3-1 at the corners for the excess rotations, times 3/(2 area) and
# the side's length squared; at the middle of a side they are the mean of those at its ends.
AT_CORNERS = (
    ((1, 2, 1), (0, 1, -1), (-1, -1, -2)),
    ((-2, -1, -1), (1, 1, 2), (-1, 0, 1)),
    ((1, -1, 0), (-1, -2, -1), (2, 1, 1)),
)


def opt(t: Cell) -> MembraneStrains:
    """Strains of the optimal triangle, and its higher-order stiffness.

    The basic strain is constant: the strain of the linear triangle with corner i displaced in
    addition by -(3/4) e3 x r_i tz_i, r_i from the centroid:

        e = sum_i (gx u', gy v', gy u' + gx v')_i,   u' = u + (3/4) y tz,   v' = v - (3/4) x tz.

    The basic strain does not include the excess rotations th = tz - (v,x - u,y)/2. They strain
    the sides by eps_k = (2 area/3) Q_k th / L_k^2, Q linear (`AT_CORNERS`). A state with strains
    eps_k along the sides is the tensor -sum_k L_k^2 eps_k sym(g_i g_j), for g_i.t_k = -1/L_k,
    g_j.t_k = 1/L_k, and the third gradient is normal to t_k. With its components eh at the middles
    of the sides, their stiffness is (3/4) beta0 area sum eh' A eh.

    With `best_beta0` of an isotropic material, in-plane bending is exact.
    """
    half = 0.5 * ALPHA_B
    moved = [
        corner._replace(u=corner.u + half * y * corner.tz, v=corner.v - half * x * corner.tz)
        for corner, (x, y) in zip(t.corners, t.xy, strict=True)
    ]
    g, th = t.centre, as_vector(t.excess(t.corners))
    extra = []
    for i, j in t.sides:
        Q = 0.5 * (as_matrix(AT_CORNERS[i]) + as_matrix(AT_CORNERS[j]))
        along = 2.0 / 3.0 * t.area * Q * th  # L_k^2 eps_k of the three sides
        eh = as_vector((0.0, 0.0, 0.0))
        for k, (a, b) in enumerate(t.sides):
            shear = g[a][0] * g[b][1] + g[a][1] * g[b][0]
            eh -= along[k] * as_vector((g[a][0] * g[b][0], g[a][1] * g[b][1], shear))
        extra.append((0.75 * t.beta0 * t.area * t.A * eh, eh))
    return MembraneStrains([linear_strain(t.points[0], moved)], extra)


def best_beta0(A: Array) -> Array:
    """Factor beta0 for correct in-plane bending, on average over the directions, (c|1,).

    beta0 = 256 det(E)/W - 3/2 for any scale of E, at least 0.01; (1 - 4 nu^2)/2 where isotropic.

    Parameters
    ----------
    A : (c|1, 3, 3) membrane stiffness [N/m]
    """
    a, b, s = A[..., 0, 0], A[..., 1, 1], A[..., 2, 2]
    ab, as_, bs = A[..., 0, 1], A[..., 0, 2], A[..., 1, 2]
    mixed = 6 * ab**2 + 5 * as_**2 - 6 * as_ * bs + 5 * bs**2
    W = (
        -6 * ab**3
        + 5 * a**2 * b
        - 5 * ab**2 * b
        - b * (75 * as_**2 + 14 * as_ * bs + 3 * bs**2)
        + 2 * ab * (7 * as_**2 + 46 * as_ * bs + 7 * bs**2)
        - a * (5 * ab**2 + 3 * as_**2 - 6 * ab * b - 5 * b**2 + 14 * as_ * bs + 75 * bs**2)
        + (3 * a**2 + 82 * a * b + 3 * b**2 - 4 * mixed) * s
        + 4 * (5 * a - 6 * ab + 5 * b) * s**2
    )
    return np.maximum(256.0 * np.linalg.det(A) / W - 1.5, LOWEST)


MEMBRANE = Membrane("opt", opt, rotations=True, bow=1.5)
