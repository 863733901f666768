"""Rank of the constraints: free motions, degrees of freedom, smallest singular value."""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean, structure
from ..elements.constraints.minimum_norm import RANK_TOLERANCE
from ..elements.constraints.treatment import row_masses, scaled_jacobian
from ..elements.joints.table import DRIVES, NAMES
from ..evaluation.dense_equations import Equations, assemble
from ..evaluation.evaluation import evaluate
from ..linear_algebra.dependence import is_tree
from ..linear_algebra.elimination import factorise_profile, solve_profile
from ..model.model import Model
from ..model.workspace import Work, spare_work
from .independence import Independence, gram_into, new_independence, scaled_rows

CUT = 1e-6  # singular values below count as zero, relative to the largest
_NEAR = (1e-9, 1e-3)  # singular values among which a gap is searched
_NOISE = 1e-16  # what a singular value of zero is computed as
_CLEAR = 1e2  # factor between the values on both sides of the cut below which it is doubtful


class Rank(NamedTuple):
    """Rank of the constraint rows, and the singular values on both sides of the cut."""

    value: int
    rows: int
    last: float  # smallest that counts, relative to the largest; 1 without rows
    first: float  # largest that does not count; 0 if all count

    @property
    def redundant(self) -> int:
        """Number of rows that follow from the others."""
        return self.rows - self.value

    @property
    def doubtful(self) -> bool:
        """Whether the cut divides values that lie close to each other."""
        return self.first > 0.0 and self.last < _CLEAR * self.first

    @property
    def text(self) -> str:
        """What to tell a user."""
        beside = f", the next {self.first:.2g}" if self.redundant else ""
        return (
            f"rank {self.value} of {self.rows} constraint rows: smallest singular value that "
            f"counts {self.last:.2g}{beside}"
        )


def rank_of(s: Array, rows: int) -> Rank:
    """Return the rank of that many rows for singular values s (k,) in descending order."""
    if s.size == 0 or s[0] == 0.0:
        return Rank(0, rows, 1.0, 0.0)
    r = s / s[0]
    value = int(np.sum(r > CUT))
    if value < r.size and r[value - 1] < _CLEAR * r[value]:
        # The cut divides values of one size: the widest gap near it decides.
        near = [k for k in range(1, r.size) if r[k] < _NEAR[1] and r[k - 1] > _NEAR[0]]
        value = max(near, key=lambda k: r[k - 1] / max(r[k], _NOISE))
    first = float(r[value]) if value < r.size else 0.0
    return Rank(value, rows, float(r[value - 1]), first)


class FreeMotions(NamedTuple):
    """Null space and pseudo-inverse of the constraint Jacobian in the metric of the inertia."""

    Z: Array  # (n_vel, n_free), Phi_q Z = 0, Z' S Z = 1
    Z_left: Array  # (n_free, n_vel) Z' S
    P: Array  # (n_vel, n_c) pseudo-inverse: Phi_q P r = r for consistent r, Z_left P = 0
    rank: Rank


def free_motions(equations: Equations, inertia_scale: Array) -> FreeMotions:
    """Return the free motions at an evaluation; `inertia_scale` (n_vel,) is S of the model."""
    Phi_q = equations.Phi_q
    root = np.sqrt(inertia_scale)
    n_c, n = Phi_q.shape
    if n_c == 0:
        return FreeMotions(
            np.diag(1.0 / root), np.diag(root), np.zeros((n, 0)), rank_of(root[:0], 0)
        )
    U, s, Vt = np.linalg.svd(scaled_jacobian(Phi_q, inertia_scale))
    rank = rank_of(s, n_c)
    k = rank.value
    lengths = np.sqrt(row_masses(Phi_q, inertia_scale))
    P = (Vt[:k].T / root[:, None]) @ (U[:, :k] / s[:k]).T * lengths
    return FreeMotions(Vt[k:].T / root[:, None], Vt[k:] * root, P, rank)


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


_INDEPENDENT = 1e3 * RANK_TOLERANCE  # smallest singular value of rows of length one


def degrees_of_freedom(model: Model, y: Array, t: float = 0.0, *, independent: bool = False) -> int:
    """Return the number of independent velocities in state y (n,) with joints but without drives.

    Modes are counted; drives do not reduce the number. In a singular position the number is
    larger than elsewhere. `independent`: no row depends on others in this state, as is known.
    """
    rows = [
        row
        for joint, kind in enumerate(model.joint_kind)
        if NAMES[kind] not in DRIVES
        for row in range(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))
    ]
    if not rows:
        return model.n_vel
    if independent or clearly_independent(model, y, t):
        return model.n_vel - len(rows)
    Phi_q = assemble(model, t, y).Phi_q
    s = np.linalg.svd(scaled_jacobian(Phi_q[rows], model.inertia_scale), compute_uv=False)
    return int(model.n_vel - np.sum(s > RANK_TOLERANCE * s[0]))


def clearly_independent(model: Model, y: Array, t: float = 0.0) -> bool:
    """Tell whether all constraints, drives too, are far from dependent in state y (n,).

    The time is linear in the number of bodies.
    """
    if not 0 < model.n_constraint <= model.n_vel:
        return False
    if is_tree(model):  # the singular value falls with the square of the length of a chain
        return True
    rows = new_independence(model)
    C, memory = np.zeros_like(rows.C), new_spectrum(rows)
    return smallest_at(model, spare_work(model), rows, memory, 0, t, y, C) > _INDEPENDENT
