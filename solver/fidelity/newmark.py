"""Newmark's method for M qdd + D qd + K q = p with masses that are constant between samples.

gamma = 0.55 damps what the output times do not resolve.
"""

import numpy as np

from ..math.arrays import Array, IntArray
from ..math.compiled import lean

GAMMA = 0.55
BETA = 0.25 * (GAMMA + 0.5) ** 2
HELD = 1e-12  # of the largest mass: a direction that joints hold has none


def newmark(
    t: Array,
    p: Array,
    masses: Array,
    at: IntArray,
    K: Array,
    D: Array,
    start: Array | None,
    rate: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Return coordinates, rates and accelerations (k, m) at times t (k,), from rest.

    Parameters
    ----------
    p : (k, m)
    masses, at : (s, m, m) and the s rows of t from which each holds; K, D : (m, m)
    start : (m,) coordinates in which the motion starts, in equilibrium; None: zero
    rate : (m,) rates of the start, with `start`; None: zero
    """
    q, v, a = (np.zeros(p.shape) for _ in range(3))
    if not p.size:
        return q, v, a
    if start is None:
        a[0] = np.linalg.solve(_positive(masses[0]), p[0])
    else:
        q[0] = start
        if rate is not None:
            v[0] = rate
    # The matrix of a step changes with the mass and, rarely, with the step.
    h = np.diff(t, prepend=t[:1])
    segment = np.searchsorted(at, np.arange(len(t)), side="right") - 1
    steps, which = np.unique(
        np.column_stack([segment, np.round(h, 12)])[1:], axis=0, return_inverse=True
    )
    step = steps[:, 1, None, None]
    with_mass = masses[steps[:, 0].astype(np.int64)]
    matrices = with_mass + GAMMA * step * D + BETA * step**2 * K
    solvers = np.asarray(np.linalg.inv(matrices), dtype=np.float64)
    number = np.concatenate([[0], which.ravel()]).astype(np.int64)
    space = np.zeros((3, p.shape[1]))
    p, K, D = (np.ascontiguousarray(part) for part in (p, K, D))
    _march(h, p, K, D, _filled(K, D), solvers, number, q, v, a, space)
    return q, v, a


@lean
def _march(
    h: Array,
    p: Array,
    K: Array,
    D: Array,
    filled: IntArray,
    solvers: Array,
    number: IntArray,
    q: Array,
    v: Array,
    a: Array,
    space: Array,
) -> None:
    """Fill q, v, a (k, m) from row 1; `solvers` (n, m, m) by their `number` (k,).

    K and D are zero outside the columns `filled` (m, 2) of each row.
    """
    m = p.shape[1]
    q_p, v_p, left = space[0], space[1], space[2]
    for k in range(1, p.shape[0]):
        step = h[k]
        for i in range(m):
            q_p[i] = q[k - 1, i] + step * v[k - 1, i] + (0.5 - BETA) * step * step * a[k - 1, i]
            v_p[i] = v[k - 1, i] + (1.0 - GAMMA) * step * a[k - 1, i]
        for i in range(m):
            sum_i = p[k, i]
            for j in range(filled[i, 0], filled[i, 1]):
                sum_i -= K[i, j] * q_p[j] + D[i, j] * v_p[j]
            left[i] = sum_i
        for i in range(m):
            sum_i = 0.0
            for j in range(m):
                sum_i += solvers[number[k], i, j] * left[j]
            a[k, i] = sum_i
            q[k, i] = q_p[i] + BETA * step * step * sum_i
            v[k, i] = v_p[i] + GAMMA * step * sum_i


def _filled(K: Array, D: Array) -> IntArray:
    """Return the first column of each row of K and D that is not zero, and that after the last."""
    m, used = len(K), (K != 0.0) | (D != 0.0)
    some = used.any(axis=1)
    first = np.where(some, used.argmax(axis=1), 0)
    last = np.where(some, m - used[:, ::-1].argmax(axis=1), 0)
    return np.column_stack([first, last]).astype(np.int64)


def _positive(M: Array) -> Array:
    """Mass without the round-off that makes held directions negative."""
    values, V = np.linalg.eigh(0.5 * (M + M.T))
    return np.asarray((V * np.maximum(values, HELD * values[-1])) @ V.T)
