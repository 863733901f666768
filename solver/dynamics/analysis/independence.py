"""Whether constraints can lose rank between two states: a certificate that is linear in the bodies.

C (n_c, n_vel) is the Jacobian with rows of length one in the metric of the inertia
(elements/constraints/treatment.py). With C_m = (C_a + C_b) / 2 and D = C_b - C_a,

    H = (C_a C_b' + C_b C_a') / 2 = C_m C_m' - D D' / 4.

If H is positive definite, |C_m' u| > |D' u| / 2 for every u, and no matrix C_m + s D, |s| <= 1/2,
loses rank: the straight way from C_a to C_b passes no singular position. H has the profile of
C C'; pivots of its L D L' tell definiteness. Their least, over the diagonal, is of the order of
the square of the smallest singular value where a and b are close.

A step in which H is not positive definite is divided: C turns with the bodies, and is far from
straight in a long step. Within a step positions are the cubic through its ends and their rates.

Rows that follow from others are left out: a choice of independent rows loses rank wherever the
whole does.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean, structure
from ..evaluation.evaluation import evaluate
from ..linear_algebra.elimination import factorise_profile
from ..model.coordinates import rates_into
from ..model.model import Model, state_size
from ..model.order import Order, padded, row_order
from ..model.workspace import Work

CERTAIN = 1e-10  # least pivot of a step that has no singular position
MOST_PARTS = 64  # of a step


@structure
class Independence(NamedTuple):
    """Memory of the certificate, and the state that was seen last."""

    order: Order  # of all constraint rows
    kept: IntArray  # (n_c,) 1: one of the independent rows
    C: Array  # (nb, r, n) of each body at the last state
    C_now: Array  # and at this one
    parts: Array  # (2, nb, r, n) at ends of a part of a step
    t: Array  # (1,) of the last state [s]
    y: Array  # (n,)
    rate: Array  # (n,) of its positions
    rate_now: Array  # (n,)
    inside: Array  # (n,) a state within the step
    length: Array  # (n_c,) of the rows before they are scaled
    root: Array  # (n_vel,) 1 / sqrt(inertia_scale)
    H: Array  # profile
    diagonal: Array  # (n_c,) by place
    pivot: Array  # (n_c,)


def new_independence(model: Model) -> Independence:
    """Return memory for a model; all rows are kept."""
    plan, n_c, n = model.plan, model.n_constraint, state_size(model)
    at_body = [
        plan.body_row[plan.row_start[i] : plan.row_start[i + 1]].tolist()
        for i in range(model.n_body)
    ]
    bodies = _bodies(model, at_body)
    every = np.ones(len(bodies), dtype=bool)
    order = row_order(bodies, model.joint_row, every, len(bodies), at_body)
    blocks = (model.n_body, order.most_rows, plan.widest)
    return Independence(
        order,
        np.ones(n_c, dtype=np.int64),
        np.zeros(blocks),
        np.zeros(blocks),
        np.zeros((2, *blocks)),
        np.zeros(1),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n_c),
        1.0 / np.sqrt(model.inertia_scale),
        np.zeros(int(order.profile_start[n_c])),
        np.zeros(n_c),
        np.zeros(n_c),
    )


def _bodies(model: Model, at_body: Sequence[Sequence[int]]) -> IntArray:
    """Return the bodies of each joint and coupling, (nj, 2 or more)."""
    found: list[list[int]] = [[] for _ in model.joint_kind]
    for i, rows in enumerate(at_body):
        for k in dict.fromkeys((np.searchsorted(model.joint_row, rows, side="right") - 1).tolist()):
            found[k].append(i)
    return padded(found)


@lean
def begin(model: Model, work: Work, rows: Independence, t: float, y: Array) -> float:
    """Take a state as the last one; return its least pivot."""
    evaluate(model, work, t, y)
    scaled_rows(model, work, rows, rows.C_now)
    rates_into(model, y, rows.rate_now)
    _remember(rows, t, y)
    return least_pivot(model, rows, rows.C, rows.C)


@lean
def scaled_jacobian_into(
    model: Model, work: Work, rows: Independence, t: float, y: Array, out: Array
) -> None:
    """Fill out (n_c, n_vel), zeros before, with C of all rows in state y."""
    C, plan = rows.parts[0], model.plan
    evaluate(model, work, t, y)
    scaled_rows(model, work, rows, C)
    for i in range(model.n_body):
        first = plan.row_start[i]
        for p in range(plan.row_start[i + 1] - first):
            for k in range(plan.size[i]):
                out[plan.body_row[first + p], model.vel_start[i] + k] += C[i, p, k]


@inlined
def certificate(model: Model, work: Work, rows: Independence, t: float, y: Array) -> float:
    """Return the least pivot of the step from the last state to (t, y), evaluated just now.

    Above CERTAIN: no singular position in the step, or in any of its parts. (t, y) becomes the
    last state.
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
    model: Model, work: Work, rows: Independence, t: float, y: Array, parts: int
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
def scaled_rows(model: Model, work: Work, rows: Independence, C: Array) -> None:
    """Fill C (nb, r, n) of the last evaluation."""
    plan, length, root, J = model.plan, rows.length, rows.root, work.J
    length[:] = 0.0
    for i in range(model.n_body):
        first, v = plan.row_start[i], model.vel_start[i]
        for p in range(plan.row_start[i + 1] - first):
            s = 0.0
            for k in range(plan.size[i]):
                c = J[i, k, p] * root[v + k]
                C[i, p, k] = c
                s += c * c
            length[plan.body_row[first + p]] += s
    for row in range(length.shape[0]):
        length[row] = np.sqrt(length[row])
    for i in range(model.n_body):
        first = plan.row_start[i]
        for p in range(plan.row_start[i + 1] - first):
            whole = length[plan.body_row[first + p]]
            for k in range(plan.size[i]):
                C[i, p, k] = C[i, p, k] / whole if whole > 0.0 else 0.0


@lean
def least_pivot(model: Model, rows: Independence, A: Array, B: Array) -> float:
    """Return the least pivot of H for C_a = A and C_b = B (nb, r, n), over the diagonal entry.

    -1 where a row turns by a right angle or more, or is not finite.
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
def gram_into(model: Model, order: Order, kept: IntArray, A: Array, B: Array, H: Array) -> None:
    """Fill the profile H of (C_a C_b' + C_b C_a') / 2, A and B (nb, r, n).

    Rows with kept (n_c,) = 0 are those of the identity.
    """
    plan, place, profile = model.plan, order.place, order.profile_start
    for k in range(H.shape[0]):
        H[k] = 0.0
    for i in range(model.n_body):
        first, n = plan.row_start[i], plan.size[i]
        r = plan.row_start[i + 1] - first
        for p in range(r):
            row = plan.body_row[first + p]
            start = profile[place[row] + 1] - 1 - place[row]
            for q in range(r):
                other = plan.body_row[first + q]
                if place[other] <= place[row] and kept[row] * kept[other] > 0:
                    s = 0.0
                    for k in range(n):
                        s += A[i, p, k] * B[i, q, k] + B[i, p, k] * A[i, q, k]
                    H[start + place[other]] += 0.5 * s
    for row in range(place.shape[0]):
        if kept[row] == 0:
            H[profile[place[row] + 1] - 1] = 1.0
