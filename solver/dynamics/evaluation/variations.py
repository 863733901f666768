"""First variations of the equations of motion about states, at known accelerations and multipliers.

The terms of a state, one after the other, are

    f - M a - Phi_q' lambda, gamma - Phi_q a, Phi, Phidot, and the rates of auxiliary states.

At fixed a and lambda they need no factorisation, and they are linear in masses and stiffnesses.
"""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import lean
from ..model.coordinates import move
from ..model.model import GAMMA, PHI, Model, Workspace, spare_workspace
from .evaluation import auxiliary_rates_into, evaluate, evaluate_rates


def width(model: Model) -> int:
    """Return how many terms a state has."""
    return int(model.n_vel + 3 * model.n_constraint + model.n_aux)


def terms(model: Model, t: Array, y: Array, a: Array, multipliers: Array) -> Array:
    """Return the terms (k, w) of states y (k, n) at times t (k,).

    Parameters
    ----------
    a, multipliers : (k, n_vel), (k, n_c)
    """
    values = np.zeros((t.size, width(model)))
    t, y, a, multipliers = (np.ascontiguousarray(part) for part in (t, y, a, multipliers))
    _terms(model, spare_workspace(model), t, y, a, multipliers, np.empty(y.shape[1]), values)
    return values


def residuals(model: Model, t: Array, y: Array, a: Array, multipliers: Array) -> Array:
    """Return f - M a - Phi_q' lambda, (k, n_vel); arguments as of `terms`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    a : accelerations (k, n_vel)
    multipliers : multipliers of the constraints (k, n_c)
    """
    return terms(model, t, y, a, multipliers)[:, : model.n_vel]


def along_directions(
    model: Model, t: Array, y: Array, a: Array, multipliers: Array, directions: Array, step: Array
) -> Array:
    """Return derivatives of the terms along directions, (k, d, w), by forward differences.

    Parameters
    ----------
    directions : (k, d, 2 n_vel + n_aux), displacements along the velocity coordinates, changes of
        velocities and of auxiliary states
    step : (k, d), of each direction
    """
    k, d = step.shape
    values = np.zeros((k, d, width(model)))
    memory, base = np.empty(y.shape[1]), np.empty(width(model))
    work = spare_workspace(model)
    _along(model, work, t, y, a, multipliers, directions, step, memory, base, values)
    return values


@lean
def _terms(
    model: Model,
    work: Workspace,
    t: Array,
    y: Array,
    a: Array,
    multipliers: Array,
    r: Array,
    out: Array,
) -> None:
    for k in range(t.shape[0]):
        _terms_into(model, work, t[k], y[k], a[k], multipliers[k], r, out[k])


@lean
def _along(
    model: Model,
    work: Workspace,
    t: Array,
    y: Array,
    a: Array,
    multipliers: Array,
    directions: Array,
    step: Array,
    memory: Array,
    base: Array,
    out: Array,
) -> None:
    n_pos, n_vel, n_aux = model.n_pos, model.n_vel, model.n_aux
    for k in range(t.shape[0]):
        _terms_into(model, work, t[k], y[k], a[k], multipliers[k], memory, base)
        for d in range(step.shape[1]):
            h, one = step[k, d], directions[k, d]
            # the last n_vel numbers that `move` reads are a step: out is memory for it
            for i in range(y.shape[1]):
                memory[i] = y[k, i]
            for i in range(n_vel):
                out[k, d, i] = h * one[i]
                memory[n_pos + i] += h * one[n_vel + i]
            for i in range(n_aux):
                memory[n_pos + n_vel + i] += h * one[2 * n_vel + i]
            move(model, memory, out[k, d, :n_vel])
            _terms_into(model, work, t[k], memory, a[k], multipliers[k], memory, out[k, d])
            for i in range(out.shape[2]):
                out[k, d, i] = (out[k, d, i] - base[i]) / h


@lean
def _terms_into(
    model: Model,
    work: Workspace,
    t: float,
    y: Array,
    a: Array,
    multipliers: Array,
    memory: Array,
    out: Array,
) -> None:
    """Fill out (w,) with the terms of one state; memory (n,) may be y, which is lost then."""
    n_vel, n_c, n_aux = model.n_vel, model.n_constraint, model.n_aux
    layout, row_start, body_row = model.layout, model.layout.row_start, model.layout.body_row
    for k in range(n_c):
        work.multipliers[k] = multipliers[k]
    evaluate(model, work, t, y)
    evaluate_rates(model, work, y)
    for k in range(n_c):
        out[n_vel + k] = work.rows[k, GAMMA]
        out[n_vel + n_c + k] = work.rows[k, PHI]
        out[n_vel + 2 * n_c + k] = work.left[k]
    for i in range(model.n_body):
        j, begin = model.vel_start[i], row_start[i]
        M, J = work.M[i], work.J[i]
        for c in range(layout.size[i]):
            out[j + c] = work.f[i, c]
        for c in range(layout.size[i]):
            own = M[c, c] * a[j + c]
            for b in range(min(c, layout.lead[i])):
                own += M[c, b] * a[j + b]
                out[j + b] -= M[c, b] * a[j + c]
            for p in range(row_start[i + 1] - begin):
                row = body_row[begin + p]
                own += J[c, p] * multipliers[row]
                out[n_vel + row] -= J[c, p] * a[j + c]
            out[j + c] -= own
    auxiliary_rates_into(model, work, t, memory)
    first = model.n_pos + n_vel
    for j in range(n_aux):
        out[n_vel + 3 * n_c + j] = memory[first + j]
