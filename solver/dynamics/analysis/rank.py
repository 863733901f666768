"""Rank of the constraints: free motions, degrees of freedom, and a certificate between two states.

C (n_c, n_vel) is the Jacobian with rows of length one in the metric of the inertia
(elements/constraints/treatment.py). With C_m = (C_a + C_b) / 2 and D = C_b - C_a,

    H = (C_a C_b' + C_b C_a') / 2 = C_m C_m' - D D' / 4.

If H is positive definite, |C_m' u| > |D' u| / 2 for every u, and no matrix C_m + s D, |s| <= 1/2,
loses rank: the straight way from C_a to C_b passes no singular position. H has the profile of
C C'; pivots of its L D L' show definiteness. Their least, over the diagonal, is of the order of
the square of the smallest singular value where a and b are close.

A step in which H is not positive definite is divided: C turns with the bodies, and is far from
straight in a long step. Within a step positions are the cubic through its ends and their rates.

Rows that follow from others are left out: a choice of independent rows loses rank wherever the
whole does.
"""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from ...math.arrays import Array, IntArray, zeros_of
from ...math.compiled import inlined, lean, structure
from ..elements.constraints.treatment import row_masses, scaled_jacobian
from ..elements.joints.table import DRIVES, NAMES
from ..evaluation.accelerations import Equations, assemble
from ..evaluation.elimination import factorise_profile, is_tree, solve_profile
from ..evaluation.evaluation import evaluate
from ..model.coordinates import rates_into
from ..model.layout import RowOrder, padded, row_order
from ..model.model import Model, Workspace, spare_workspace, state_size
from ..tolerances import (
    CERTAIN,
    INDEPENDENT,
    LEAST_BESIDE_ZEROS,
    LEAST_EIGENVALUE,
    RANK_CUT,
    RANK_GAP,
    RANK_GAP_WITHIN,
    RANK_TOLERANCE,
    RESIDUAL_ROUNDING,
    SHIFT_FOUND,
    ZERO_SINGULAR,
)

MOST_PARTS = 64  # of a step


@structure
class Independence(NamedTuple):
    """Memory of the certificate, and the state that was seen last."""

    order: RowOrder  # of all constraint rows
    kept: IntArray  # (n_c,) 1: one of the independent rows
    C: Annotated[Array, "nb, r, widest"]  # of each body at the last state
    C_now: Annotated[Array, "nb, r, widest"]  # and at this one
    parts: Annotated[Array, "2, nb, r, widest"]  # at ends of a part of a step
    t: Annotated[Array, "1"]  # of the last state [s]
    y: Annotated[Array, "n"]
    rate: Annotated[Array, "n"]  # of its positions
    rate_now: Annotated[Array, "n"]
    inside: Annotated[Array, "n"]  # a state within the step
    length: Annotated[Array, "n_c"]  # of the rows before they are scaled
    root: Array  # (n_vel,) 1 / sqrt(inertia_scale)
    H: Annotated[Array, "profile"]
    diagonal: Annotated[Array, "n_c"]  # by place
    pivot: Annotated[Array, "n_c"]


def new_independence(model: Model) -> Independence:
    """Return memory for a model; all rows are kept."""
    layout, n_c, n = model.layout, model.n_constraint, state_size(model)
    at_body = [
        layout.body_row[layout.row_start[i] : layout.row_start[i + 1]].tolist()
        for i in range(model.n_body)
    ]
    bodies = _bodies(model, at_body)
    every = np.ones(len(bodies), dtype=bool)
    order = row_order(bodies, model.joint_row, every, len(bodies), at_body)
    profile = int(order.profile_start[n_c])
    sizes = {"nb": model.n_body, "r": order.most_rows, "n_c": n_c, "profile": profile}
    root = 1.0 / np.sqrt(model.inertia_scale)
    given = {"order": order, "kept": np.ones(n_c, dtype=np.int64), "root": root}
    return zeros_of(Independence, sizes | {"n": n, "widest": layout.widest}, **given)


def _bodies(model: Model, at_body: Sequence[Sequence[int]]) -> IntArray:
    """Return the bodies of each joint and coupling, (nj, 2 or more)."""
    lists: list[list[int]] = [[] for _ in model.joint_kind]
    for i, rows in enumerate(at_body):
        for k in dict.fromkeys((np.searchsorted(model.joint_row, rows, side="right") - 1).tolist()):
            lists[k].append(i)
    return padded(lists)


@lean
def begin(model: Model, work: Workspace, rows: Independence, t: float, y: Array) -> float:
    """Take a state as the last one; return its least pivot.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    rows : scaled rows of the last state, and their memory
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    evaluate(model, work, t, y)
    scaled_rows(model, work, rows, rows.C_now)
    rates_into(model, y, rows.rate_now)
    _remember(rows, t, y)
    return least_pivot(model, rows, rows.C, rows.C)


@lean
def scaled_jacobian_into(
    model: Model, work: Workspace, rows: Independence, t: float, y: Array, out: Array
) -> None:
    """Fill out (n_c, n_vel), zeros before, with C of all rows in state y.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    rows : memory of scaled rows
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    out : C (n_c, n_vel), zeros before
    """
    C, layout = rows.parts[0], model.layout
    evaluate(model, work, t, y)
    scaled_rows(model, work, rows, C)
    for i in range(model.n_body):
        first = layout.row_start[i]
        for p in range(layout.row_start[i + 1] - first):
            for k in range(layout.size[i]):
                out[layout.body_row[first + p], model.vel_start[i] + k] += C[i, p, k]


@inlined
def certificate(model: Model, work: Workspace, rows: Independence, t: float, y: Array) -> float:
    """Return the least pivot of the step from the last state to (t, y), evaluated just now.

    Above CERTAIN: no singular position in the step, or in any of its parts. (t, y) becomes the
    last state.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    rows : scaled rows of the last state, and their memory
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    scaled_rows(model, work, rows, rows.C_now)
    rates_into(model, y, rows.rate_now)
    least = least_pivot(model, rows, rows.C, rows.C_now)
    if not least > CERTAIN:
        parts = 2
        while parts <= MOST_PARTS:
            least = _least_of_parts(model, work, rows, t, y, parts)
            if least > CERTAIN:
                break
            parts *= 2
    _remember(rows, t, y)
    return least


@inlined
def _remember(rows: Independence, t: float, y: Array) -> None:
    rows.t[0] = t
    for k in range(y.shape[0]):
        rows.y[k] = y[k]
        rows.rate[k] = rows.rate_now[k]
    _copy(rows.C_now, rows.C)


@inlined
def _copy(C: Array, out: Array) -> None:
    for i in range(C.shape[0]):
        for p in range(C.shape[1]):
            for k in range(C.shape[2]):
                out[i, p, k] = C[i, p, k]


@lean
def _least_of_parts(
    model: Model, work: Workspace, rows: Independence, t: float, y: Array, parts: int
) -> float:
    """Return the least pivot of equal parts of a step; at most CERTAIN as soon as one has it."""
    least, h = 1.0, t - rows.t[0]
    _copy(rows.C, rows.parts[0])
    for part in range(1, parts + 1):
        one, two = rows.parts[(part + 1) % 2], rows.parts[part % 2]
        if part == parts:
            _copy(rows.C_now, two)
        else:
            x = part / parts
            rise, bent = x * x * (3.0 - 2.0 * x), x * (1.0 - x) * h
            for k in range(model.n_pos):
                rows.inside[k] = (1.0 - rise) * rows.y[k] + rise * y[k]
                rows.inside[k] += bent * ((1.0 - x) * rows.rate[k] - x * rows.rate_now[k])
            evaluate(model, work, rows.t[0] + x * h, rows.inside)
            scaled_rows(model, work, rows, two)
        least = min(least, least_pivot(model, rows, one, two))
        if not least > CERTAIN:
            return least
    return least


@inlined
def scaled_rows(model: Model, work: Workspace, rows: Independence, C: Array) -> None:
    """Fill C (nb, r, n) of the last evaluation.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    rows : memory of scaled rows
    C : scaled rows by bodies (nb, r, n), to fill
    """
    layout, length, root, J = model.layout, rows.length, rows.root, work.J
    length[:] = 0.0
    for i in range(model.n_body):
        first, v = layout.row_start[i], model.vel_start[i]
        for p in range(layout.row_start[i + 1] - first):
            s = 0.0
            for k in range(layout.size[i]):
                c = J[i, k, p] * root[v + k]
                C[i, p, k] = c
                s += c * c
            length[layout.body_row[first + p]] += s
    for row in range(length.shape[0]):
        length[row] = np.sqrt(length[row])
    for i in range(model.n_body):
        first = layout.row_start[i]
        for p in range(layout.row_start[i + 1] - first):
            whole = length[layout.body_row[first + p]]
            for k in range(layout.size[i]):
                C[i, p, k] = C[i, p, k] / whole if whole > 0.0 else 0.0


@lean
def least_pivot(model: Model, rows: Independence, A: Array, B: Array) -> float:
    """Return the least pivot of H for C_a = A and C_b = B (nb, r, n), over the diagonal entry.

    -1 where a row turns by a right angle or more, or is not finite.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    rows : memory of scaled rows
    A : C_a by bodies (nb, r, n)
    B : C_b by bodies (nb, r, n)
    """
    H, profile, diagonal = rows.H, rows.order.profile_start, rows.diagonal
    gram_into(model, rows.order, rows.kept, A, B, H)
    for k in range(diagonal.shape[0]):
        diagonal[k] = H[profile[k + 1] - 1]
    factorise_profile(rows.order, H, rows.pivot)
    least = 1.0
    for k in range(diagonal.shape[0]):
        if not diagonal[k] > 0.0:
            return -1.0
        ratio = H[profile[k + 1] - 1] / diagonal[k]
        if ratio < least:
            least = ratio
        elif ratio != ratio:
            return -1.0
    return least


@inlined
def gram_into(model: Model, order: RowOrder, kept: IntArray, A: Array, B: Array, H: Array) -> None:
    """Fill the profile H of (C_a C_b' + C_b C_a') / 2, A and B (nb, r, n).

    Rows with kept (n_c,) = 0 are those of the identity.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    order : order of the rows, and their profile
    kept : 1 of rows that count, 0 of others (n_c,)
    A : C_a by bodies (nb, r, n)
    B : C_b by bodies (nb, r, n)
    H : profile, to fill
    """
    layout, place, profile = model.layout, order.place, order.profile_start
    for k in range(H.shape[0]):
        H[k] = 0.0
    for i in range(model.n_body):
        first, n = layout.row_start[i], layout.size[i]
        r = layout.row_start[i + 1] - first
        for p in range(r):
            row = layout.body_row[first + p]
            start = profile[place[row] + 1] - 1 - place[row]
            for q in range(r):
                other = layout.body_row[first + q]
                if place[other] <= place[row] and kept[row] * kept[other] > 0:
                    s = 0.0
                    for k in range(n):
                        s += A[i, p, k] * B[i, q, k] + B[i, p, k] * A[i, q, k]
                    H[start + place[other]] += 0.5 * s
    for row in range(place.shape[0]):
        if kept[row] == 0:
            H[profile[place[row] + 1] - 1] = 1.0


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
        return self.first > 0.0 and self.last < RANK_GAP * self.first

    @property
    def text(self) -> str:
        """Text for the user."""
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
    value = int(np.sum(r > RANK_CUT))
    if value < r.size and r[value - 1] < RANK_GAP * r[value]:
        # The cut divides values of one size: the widest gap near it decides.
        low, high = RANK_GAP_WITHIN
        near = [k for k in range(1, r.size) if r[k] < high and r[k - 1] > low]
        value = max(near, key=lambda k: r[k - 1] / max(r[k], ZERO_SINGULAR))
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


MOST_SHIFTS = 100


@structure
class Spectrum(NamedTuple):
    """Memory of the search; vectors by place."""

    every: IntArray  # (n_c,) 1: all rows
    G: Annotated[Array, "size"]  # profile of C C'
    shifted: Annotated[Array, "size"]  # and of the factors of C C' - mu
    pivot: Annotated[Array, "n"]
    x: Array  # (n_c,) the singular vector found last: a good start for a state close by
    across: Annotated[Array, "n"]  # sums of the rows of |C_a - C_b|


def new_spectrum(rows: Independence) -> Spectrum:
    """Return memory for the rows of a model."""
    n_c, size = rows.kept.size, rows.H.size
    x = np.cos(np.arange(1.0, n_c + 1.0)) / np.sqrt(max(n_c, 1))  # an arbitrary direction
    return zeros_of(Spectrum, {"n": n_c, "size": size}, every=np.ones(n_c, dtype=np.int64), x=x)


@lean
def smallest_at(
    model: Model,
    work: Workspace,
    rows: Independence,
    memory: Spectrum,
    null: int,
    t: float,
    y: Array,
    C: Array,
) -> float:
    """Fill C (nb, r, n) of state y at time t; return its smallest singular value that counts.

    `null` singular values of its n_c rows are zero and do not count.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    rows : memory of scaled rows
    memory : memory of the search
    null : number of singular values that are zero
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    C : scaled rows by bodies (nb, r, n), to fill
    """
    evaluate(model, work, t, y)
    scaled_rows(model, work, rows, C)
    return smallest_singular_value(model, rows, memory, null, C)


@lean
def smallest_singular_value(
    model: Model, rows: Independence, memory: Spectrum, null: int, C: Array
) -> float:
    """Return the smallest singular value of C (nb, r, n) after `null` that are zero.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    rows : memory of scaled rows
    memory : memory of the search; its vector begins and ends the search
    null : number of singular values that are zero
    C : scaled rows by bodies (nb, r, n)
    """
    gram_into(model, rows.order, memory.every, C, C, memory.G)
    x = memory.x
    floor = LEAST_BESIDE_ZEROS if null > 0 else LEAST_EIGENVALUE
    low, high = floor, float(x.shape[0])
    sigma = _along(model, rows, C, x)
    if not (sigma > low and sigma < high):
        sigma = np.sqrt(low * high)
    for _ in range(MOST_SHIFTS):
        shift = max(floor, sigma * (1.0 - SHIFT_FOUND))
        below = _factorise(rows, memory, shift)
        if below > null:
            high = min(high, shift)
        else:
            low = max(low, shift)
        solve_profile(rows.order, memory.shifted, memory.pivot, x)
        size = _normalised(x)
        sigma = _along(model, rows, C, x)
        if high <= floor:
            return np.sqrt(min(sigma, floor))
        if below <= null and (4.0 * SHIFT_FOUND * shift + RESIDUAL_ROUNDING) * size >= 1.0:
            return np.sqrt(sigma)
        if high <= low * (1.0 + SHIFT_FOUND):
            return np.sqrt(high)
        if not (sigma > low and sigma < high):
            sigma = np.sqrt(low * high)
            for k in range(x.shape[0]):  # x may lack the direction that is sought
                x[k] += np.cos(k + 1.0) / np.sqrt(1.0 * x.shape[0])
            _normalised(x)
    return np.sqrt(high)


@lean
def difference(model: Model, memory: Spectrum, A: Array, B: Array) -> float:
    """Return a bound of the largest singular value of C_a - C_b, A and B (nb, r, n).

    The root of the largest sum of a column times the largest of a row.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    memory : memory of the search
    A : C_a by bodies (nb, r, n)
    B : C_b by bodies (nb, r, n)
    """
    layout, across, widest = model.layout, memory.across, 0.0
    across[:] = 0.0
    for i in range(model.n_body):
        first = layout.row_start[i]
        for k in range(layout.size[i]):
            s = 0.0
            for p in range(layout.row_start[i + 1] - first):
                d = abs(A[i, p, k] - B[i, p, k])
                s += d
                across[layout.body_row[first + p]] += d
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
    layout, place, total = model.layout, rows.order.place, 0.0
    for i in range(model.n_body):
        first = layout.row_start[i]
        for k in range(layout.size[i]):
            s = 0.0
            for p in range(layout.row_start[i + 1] - first):
                s += C[i, p, k] * x[place[layout.body_row[first + p]]]
            total += s * s
    return total


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


def degrees_of_freedom(model: Model, y: Array, *, independent: bool = False) -> int:
    """Return the number of independent velocities at the start y (n,), with joints but no drives.

    Modes are counted; drives do not reduce the number. In a singular position the number is
    larger than elsewhere. `independent`: no row depends on others in this state, as is known.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    independent : no row depends on others in this state, as is known
    """
    rows = [
        row
        for joint, kind in enumerate(model.joint_kind)
        if NAMES[kind] not in DRIVES
        for row in range(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))
    ]
    if not rows:
        return model.n_vel
    if independent or clearly_independent(model, y):
        return model.n_vel - len(rows)
    Phi_q = assemble(model, 0.0, y).Phi_q
    s = np.linalg.svd(scaled_jacobian(Phi_q[rows], model.inertia_scale), compute_uv=False)
    return int(model.n_vel - np.sum(s > RANK_TOLERANCE * s[0]))


def clearly_independent(model: Model, y: Array) -> bool:
    """Return whether all constraints, drives too, are far from dependent in state y (n,) at t = 0.

    The time is linear in the number of bodies.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    """
    if not 0 < model.n_constraint <= model.n_vel:
        return False
    if is_tree(model):  # the singular value falls with the square of the length of a chain
        return True
    rows = new_independence(model)
    C, memory = np.zeros_like(rows.C), new_spectrum(rows)
    return smallest_at(model, spare_workspace(model), rows, memory, 0, 0.0, y, C) > INDEPENDENT
