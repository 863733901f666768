"""OPT: the optimal membrane triangle with drilling rotations (Felippa 2003)."""

import numpy as np

from ....solver.math.arrays import Array
from ..drilling.excess import excess_rotation
from ..triangles import END, START, Triangles
from .contract import Membrane
from .strains import MembraneStrains, linear_strain

ALPHA_B = 1.5
LOWEST = 0.01  # lower bound of beta0

# Strains along sides 1-2, 2-3, 3-1 at the corners for the excess rotations, times 3/(2 area) and
# the side's length squared; at the middle of a side they are the mean of those at its ends.
AT_CORNERS = np.array(
    [
        [[1, 2, 1], [0, 1, -1], [-1, -1, -2]],
        [[-2, -1, -1], [1, 1, 2], [-1, 0, 1]],
        [[1, -1, 0], [-1, -2, -1], [2, 1, 1]],
    ],
    dtype=float,
)
AT_SIDES = 0.5 * (AT_CORNERS[list(START)] + AT_CORNERS[list(END)])
# sum over the sides of Q' N Q as a linear map of N, (9, 9)
SIDE_SUM = np.einsum("pia,pjb->ijab", AT_SIDES, AT_SIDES).reshape(9, 9)


def opt(t: Triangles, A: Array, beta0: float | str) -> MembraneStrains:
    """Strains of the optimal triangle, and its higher-order stiffness.

    The basic strain is constant: the strain of the linear triangle with corner i displaced in
    addition by -(3/4) e3 x r_i tz_i, r_i from the centroid:

        e = sum_i (gx u', gy v', gy u' + gx v')_i,   u' = u + (3/4) y tz,   v' = v - (3/4) x tz.

    The basic strain does not include the excess rotations th = tz - (v,x - u,y)/2. They strain
    the sides by eps_k = (2 area/3) Q_k(l) th / L_k^2, Q linear (`AT_CORNERS`). A state with
    strains eps_k along the sides is the tensor -sum_k L_k^2 eps_k sym(g_i g_j), for
    g_i.t_k = -1/L_k, g_j.t_k = 1/L_k, and the third gradient is normal to t_k. With R these
    columns without their factors, summed over the middles of the sides,

        extra = (3/4) beta0 area (2 area/3)^2 th' [sum Q' (R' A R) Q] th.

    With `best_beta0` of an isotropic material, in-plane bending is exact.
    """
    Bm = linear_strain(t)
    x, y = 0.5 * ALPHA_B * t.xy_E[..., 0], 0.5 * ALPHA_B * t.xy_E[..., 1]
    Bm[..., 2::3] = y[:, None] * Bm[..., 0::3] - x[:, None] * Bm[..., 1::3]
    gi, gj = t.grad[:, START], t.grad[:, END]
    R = np.empty((len(t), 3, 3))  # component, side
    R[:, :2] = np.swapaxes(gi * gj, 1, 2)
    R[:, 2] = gi[..., 0] * gj[..., 1] + gi[..., 1] * gj[..., 0]
    factor = best_beta0(A) if isinstance(beta0, str) else beta0
    along = np.swapaxes(R, 1, 2) @ (A @ R)
    along *= (factor / 3.0 * t.area**3)[:, None, None]
    inner = (along.reshape(-1, 9) @ SIDE_SUM).reshape(-1, 3, 3)
    T = excess_rotation(t)
    return MembraneStrains(Bm[:, None], np.swapaxes(T, 1, 2) @ (inner @ T))


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
