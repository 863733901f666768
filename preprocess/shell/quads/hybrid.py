"""Membrane of a quadrilateral: assumed resultants in equilibrium, sides that bow.

With x, y from the centroid of the area, the resultants N = P beta are the complete linear field in
equilibrium, which has no preferred axes,

    Nx = b1 + b4 y + b6 x,   Ny = b2 + b5 x + b7 y,   Nxy = b3 - b6 y - b7 x.

Displacements are needed on the sides only: linear between the corners, and bowed by
a (L_k/8) (tz_j - tz_i) P_k along n_k = (t_y, -t_x), as in Allman's triangle. With the strain
e + A^-1 B k of the displacements and the curvature k, the Hellinger-Reissner functional

    int N'(e + A^-1 B k) - N' A^-1 N/2 + k'(D - B A^-1 B) k/2

gives beta = H^-1 G u, H = int P' A^-1 P, G u = int P'(e + A^-1 B k). The part of e is the work
of P n on the sides. In a constant state neighbours fit together if their common side bows alike.
Thus a is that of the triangles (`bow` of the membrane) in rows b1 to b3, which alone do work in a
constant state, and 1 in the others.

Two motions of the rotations have no energy in this field, equal ones and alternating ones; they
get a small stiffness, which is zero in every constant state.
"""

import numpy as np

from ....solver.math.arrays import Array
from ..drilling.excess import excess
from ..quadrilaterals import CORNERS, END, START, Quadrilaterals, slopes

SPURIOUS = 0.1  # of equal rotations relative to that of the cell, to A66 (as in allman.py)
HOURGLASS = 1e-3  # of alternating rotations, to A66
ALTERNATING = CORNERS.prod(axis=1)  # 1, -1, 1, -1
CENTRE = slopes(np.zeros((1, 2)))[0]


def field(x: Array, y: Array) -> Array:
    """P at places (..., ) in E, (..., 3, 7)."""
    P = np.zeros((*x.shape, 3, 7))
    P[..., range(3), range(3)] = 1.0
    P[..., 0, 3], P[..., 0, 5] = y, x
    P[..., 1, 4], P[..., 1, 6] = x, y
    P[..., 2, 5], P[..., 2, 6] = -y, -x
    return P


def places(q: Quadrilaterals, xy: Array) -> Array:
    """P at places (c, p, 2), in units of the cell's size, so that all columns are alike."""
    scaled = xy / np.sqrt(q.area)[:, None, None]
    return field(scaled[..., 0], scaled[..., 1])


def flexibility(q: Quadrilaterals, A_inverse: Array) -> Array:
    """H (c, 7, 7) [m/N m2]."""
    P = places(q, q.interpolation @ q.xy_E)
    weighted = (q.weight[..., None, None] * A_inverse[:, None]) @ P
    return np.asarray(np.swapaxes(P, 2, 3).reshape(-1, 4, 7, 3) @ weighted).sum(axis=1)


def stretching(q: Quadrilaterals, bow: float) -> Array:
    """Part of G of the degrees of freedom (u, v, tz) of the corners, (c, 7, 12) [m, m2]."""
    c = len(q)
    t = q.tangent
    n = np.stack([t[..., 1], -t[..., 0]], axis=-1)
    # n is outward, or inward where the corners run clockwise about e3
    middle = 0.5 * (q.xy_E[:, 0] + q.xy_E[:, 1])
    outward = n * np.sign(np.einsum("ci,ci->c", n[:, 0], middle))[:, None, None]
    P = places(q, q.xy_E)  # at the corners
    N = np.zeros((c, 4, 2, 3))  # (N n) = N_matrix (Nx, Ny, Nxy)
    N[..., 0, 0] = N[..., 1, 2] = outward[..., 0]
    N[..., 1, 1] = N[..., 0, 2] = outward[..., 1]
    length = q.length[..., None, None]
    G = np.zeros((c, 4, 3, 7))
    side = np.array([bow] * 3 + [1.0] * 4)
    for k, (i, j) in enumerate(zip(START, END, strict=True)):
        first, last = N[:, k] @ P[:, i], N[:, k] @ P[:, j]  # tractions of the ends, (c, 2, 7)
        L = length[:, k]
        G[:, i, :2] += L / 6.0 * (2.0 * first + last)
        G[:, j, :2] += L / 6.0 * (first + 2.0 * last)
        across = (0.5 * (first + last) * n[:, k, :, None]).sum(axis=1)
        turning = (L[:, 0] ** 2 / 12.0) * side * across
        G[:, j, 2] += turning
        G[:, i, 2] -= turning
    return np.swapaxes(G.reshape(c, 12, 7), 1, 2)


def stiffness(q: Quadrilaterals, A: Array, bow: float) -> Array:
    """Stiffness of membranes without coupling, (c, 12, 12)."""
    G = stretching(q, bow)
    A_inverse: Array = np.asarray(np.linalg.inv(A), dtype=float)
    beta: Array = np.asarray(np.linalg.solve(flexibility(q, A_inverse), G), dtype=float)
    return np.asarray(np.swapaxes(G, 1, 2) @ beta + steadying(q, A))


def bending(q: Quadrilaterals, A_inverse: Array, B: Array, curvature: Array) -> Array:
    """Part of G of the plate's degrees of freedom, int P' A^-1 B k, (c, 7, 12)."""
    P = places(q, q.interpolation @ q.xy_E)
    weighted = (q.weight[..., None, None] * (A_inverse @ B)[:, None]) @ curvature
    return np.asarray(np.swapaxes(P, 2, 3) @ weighted).sum(axis=1)


def steadying(q: Quadrilaterals, A: Array) -> Array:
    """Stiffness of the two motions of the rotations without energy, (c, 12, 12)."""
    grad, mean = _centre_gradients(q), excess_rotation(q).mean(axis=1)
    h = ALTERNATING - np.einsum("i,cix,cjx->cj", ALTERNATING, q.xy_E, grad)
    other = np.zeros((len(q), 12))
    other[:, 2::3] = 0.25 * h
    size = (A[..., 2, 2] * q.area)[:, None, None]
    return np.asarray(
        size * (SPURIOUS * mean[:, :, None] * mean[:, None, :]
                + HOURGLASS * other[:, :, None] * other[:, None, :])
    )  # fmt: skip


def excess_rotation(q: Quadrilaterals) -> Array:
    """tz_i - (v,x - u,y)/2 of each corner, with the rotation of the centre, (c, 4, 12)."""
    return excess(_centre_gradients(q))


def _centre_gradients(q: Quadrilaterals) -> Array:
    """Gradients of N at xi = eta = 0, (c, 4, 2)."""
    J = CENTRE.T @ q.xy_E
    return np.asarray(CENTRE @ np.linalg.inv(J).swapaxes(1, 2))
