"""Smallest singular value of the scaled Jacobian that counts, linear in the number of bodies.

C (n_c, n_vel) is the Jacobian with rows of length one (independence.py). C C' has the narrow
profile of the rows; its `null` smallest eigenvalues are zero where so many rows follow from the
others. The next one, sigma^2, is found by inverse iteration with shifts,

    (C C' - mu) y = x,   x <- y / |y|,   mu <- |C' x|^2,

and the number of negative pivots of C C' - mu is the number of eigenvalues below mu (Sylvester).
It brackets the eigenvalue that is wanted: a shift outside the bracket is replaced by the geometric
mean of its ends. The result is |C' x|, which keeps the digits that a square would lose.
"""

from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray
from ..math.compiled import inlined, lean, structure
from .elimination import factorise_profile, solve_profile
from .evaluation import evaluate
from .independence import Independence, gram_into, scaled_rows
from .model import Model
from .workspace import Work

CLOSE = 1e-7  # relative distance of the last shift from the eigenvalue
FLOOR, FLOOR_WITH_NULL = 1e-17, 1e-14  # eigenvalues of C C' below are zero
ROUND_OFF = 1e-15  # of the residual of an eigenvector
MOST_SHIFTS = 100


@structure
class Spectrum(NamedTuple):
    """Memory of the search; vectors by place."""

    every: IntArray  # (n_c,) 1: all rows
    G: Array  # profile of C C'
    shifted: Array  # and of the factors of C C' - mu
    pivot: Array  # (n_c,)
    x: Array  # (n_c,) the singular vector found last: a good start for a state close by
    across: Array  # (n_c,) sums of the rows of |C_a - C_b|


def new_spectrum(rows: Independence) -> Spectrum:
    """Return memory for the rows of a model."""
    n_c, size = rows.kept.size, rows.H.size
    return Spectrum(
        np.ones(n_c, dtype=np.int64),
        np.zeros(size),
        np.zeros(size),
        np.zeros(n_c),
        np.cos(np.arange(1.0, n_c + 1.0)) / np.sqrt(max(n_c, 1)),  # an arbitrary direction
        np.zeros(n_c),
    )


@lean
def smallest_at(
    model: Model,
    work: Work,
    rows: Independence,
    memory: Spectrum,
    null: int,
    t: float,
    y: Array,
    C: Array,
) -> float:
    """Fill C (nb, r, n) of state y at time t; return its smallest singular value that counts.

    `null` singular values of its n_c rows are zero and do not count.
    """
    evaluate(model, work, t, y)
    scaled_rows(model, work, rows, C)
    return smallest_singular_value(model, rows, memory, null, C)


@lean
def smallest_singular_value(
    model: Model, rows: Independence, memory: Spectrum, null: int, C: Array
) -> float:
    """Return the smallest singular value of C (nb, r, n) after `null` that are zero."""
    gram_into(model, rows.order, memory.every, C, C, memory.G)
    x = memory.x
    floor = FLOOR_WITH_NULL if null > 0 else FLOOR
    low, high = floor, float(x.shape[0])
    found = _along(model, rows, C, x)
    if not (found > low and found < high):
        found = np.sqrt(low * high)
    for _ in range(MOST_SHIFTS):
        shift = max(floor, found * (1.0 - CLOSE))
        below = _factorise(rows, memory, shift)
        if below > null:
            high = min(high, shift)
        else:
            low = max(low, shift)
        solve_profile(rows.order, memory.shifted, memory.pivot, x)
        size = _normalised(x)
        found = _along(model, rows, C, x)
        if high <= floor:
            return np.sqrt(min(found, floor))
        if below <= null and (4.0 * CLOSE * shift + ROUND_OFF) * size >= 1.0:
            return np.sqrt(found)
        if high <= low * (1.0 + CLOSE):
            return np.sqrt(high)
        if not (found > low and found < high):
            found = np.sqrt(low * high)
            for k in range(x.shape[0]):  # x may lack the direction that is sought
                x[k] += np.cos(k + 1.0) / np.sqrt(1.0 * x.shape[0])
            _normalised(x)
    return np.sqrt(high)


@lean
def difference(model: Model, memory: Spectrum, A: Array, B: Array) -> float:
    """Return a bound of the largest singular value of C_a - C_b, A and B (nb, r, n).

    The root of the largest sum of a column times the largest of a row.
    """
    plan, across, widest = model.plan, memory.across, 0.0
    across[:] = 0.0
    for i in range(model.n_body):
        first = plan.row_start[i]
        for k in range(plan.size[i]):
            s = 0.0
            for p in range(plan.row_start[i + 1] - first):
                d = abs(A[i, p, k] - B[i, p, k])
                s += d
                across[plan.body_row[first + p]] += d
            widest = max(widest, s)
    most = 0.0
    for row in range(across.shape[0]):
        most = max(most, across[row])
    return np.sqrt(widest * most)


@inlined
def _normalised(x: Array) -> float:
    """Divide x (n_c,) by its length, which is returned."""
    size = 0.0
    for k in range(x.shape[0]):
        size += x[k] * x[k]
    size = np.sqrt(size)
    for k in range(x.shape[0]):
        x[k] = x[k] / size if size > 0.0 and size < 1e150 else np.cos(k + 1.0)
    return size


@inlined
def _along(model: Model, rows: Independence, C: Array, x: Array) -> float:
    """Return |C' x|^2, x (n_c,) by place and of length one."""
    plan, place, found = model.plan, rows.order.place, 0.0
    for i in range(model.n_body):
        first = plan.row_start[i]
        for k in range(plan.size[i]):
            s = 0.0
            for p in range(plan.row_start[i + 1] - first):
                s += C[i, p, k] * x[place[plan.body_row[first + p]]]
            found += s * s
    return found


@inlined
def _factorise(rows: Independence, memory: Spectrum, shift: float) -> int:
    """Factorise C C' - shift; return the number of its negative eigenvalues."""
    profile, S = rows.order.profile_start, memory.shifted
    for k in range(S.shape[0]):
        S[k] = memory.G[k]
    for k in range(memory.pivot.shape[0]):
        S[profile[k + 1] - 1] -= shift
    factorise_profile(rows.order, S, memory.pivot)
    below = 0
    for k in range(memory.pivot.shape[0]):
        if memory.pivot[k] < 0.0:
            below += 1
    return below
