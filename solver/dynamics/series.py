"""Evaluations of many states in one call: what signals and checks need at the output times.

All functions take times t (k,) and states y (k, n) and return arrays whose first axis is k; memory
and time are linear in k.
"""

from typing import NamedTuple

import numpy as np

from ..math.arrays import Array, IntArray
from ..math.compiled import lean
from ..math.rotations import rotation_into
from ..math.triple import cross3, minus3
from .applied_forces import force_wrench
from .bodies.marker import move_marker
from .bodies.motion import N_MOTION, place, stand
from .constraint_rows import n_coupling
from .dependence import REGULAR, is_tree
from .derivative import by_blocks, dense_derivative_into, derivative_into
from .energy import energies_into, momenta_into
from .evaluation import evaluate, evaluate_rates
from .forces.table import FIRST_LOAD
from .laws import law_at
from .model import Model, state_size
from .workspace import PHI, Work, spare_work


class Balance(NamedTuple):
    """Constraints and energies of k states."""

    Phi: Array  # (k, n_c)
    Phi_d: Array  # (k, n_c) its rate
    energies: Array  # (k, 3) kinetic, strain, potential [J]


def along_solution(
    model: Model, t: Array, y: Array, regular_above: float = REGULAR
) -> tuple[Array, Array]:
    """Return dy/dt (k, n) and the multipliers (k, n_c). Paper: Eq. (14).

    The rates are those that are integrated. Multipliers of redundant constraints are those of
    least norm; with the augmented Lagrangian, those of the equations without it, so that the
    balance of momentum shows whether its iteration has converged.

    Below `regular_above`, the least pivot over its diagonal entry, states are solved with dense
    matrices, in the third power of the number of bodies.
    """
    t, y = _contiguous(t, y)
    rates, multipliers = np.zeros(y.shape), np.zeros((t.size, model.n_constraint))
    regular, work = np.zeros(t.size), spare_work(model)
    if by_blocks(model):
        _derivatives(model, work, t, y, rates, multipliers, regular)
    # Rows that nearly depend on each other: elimination loses digits that pivoting keeps.
    doubtful = regular < regular_above
    if model.redundant == 0 and doubtful.any() and is_tree(model):
        doubtful[:] = False
    if model.penalty > 0.0 and model.beta > 0.0:
        doubtful[:] = True
    spare = np.zeros(state_size(model))
    for k in np.flatnonzero(doubtful).tolist():
        into = rates[k] if model.penalty == 0.0 else spare
        multipliers[k] = dense_derivative_into(model, work, float(t[k]), y[k], into)
    return rates, multipliers


def balance(model: Model, t: Array, y: Array) -> Balance:
    """Return constraints and energies."""
    t, y = _contiguous(t, y)
    Phi, Phi_d = np.zeros((t.size, model.n_constraint)), np.zeros((t.size, model.n_constraint))
    energies = np.zeros((t.size, 3))
    _balances(model, spare_work(model), t, y, Phi, Phi_d, energies)
    return Balance(Phi, Phi_d, energies)


def generalised_momenta(model: Model, t: Array, y: Array) -> Array:
    """Return M v, (k, n_vel)."""
    t, y = _contiguous(t, y)
    found = np.zeros((t.size, model.n_vel))
    _momenta(model, spare_work(model), t, y, found)
    return found


def mass_matrices(model: Model, i: int, t: Array, y: Array) -> Array:
    """Return the mass matrix of body i, (k, m + 6, m + 6)."""
    t, y = _contiguous(t, y)
    n = int(model.plan.size[i])
    found = np.zeros((t.size, n, n))
    _masses(model, spare_work(model), i, t, y, found)
    return found


def loaded_markers(model: Model) -> IntArray:
    """Return the marker of each load of `marker_loads`, (n,)."""
    pairs = model.quantities.marker[model.quantities.coupling_coordinate]
    return np.concatenate([a.ravel() for a in (model.joint_marker, model.force_marker, pairs)])


def marker_loads(model: Model, t: Array, y: Array, multipliers: Array) -> Array:
    """Return forces [N] and moments [N m] of joints and force elements, (k, n, 6), on both sides.

    Global components; the moment is about the origin of the marker of that side
    (`loaded_markers`). Those of joints are -C' lambda with the coefficients C of the joint's rows,
    which do the same virtual work; multipliers (k, n_c). A load from outside acts on the second
    marker alone. Couplings of coordinates act on the markers of all their terms, which come last.
    """
    t, y = _contiguous(t, y)
    found = np.zeros((t.size, loaded_markers(model).size, 6))
    _loads(model, spare_work(model), t, y, np.ascontiguousarray(multipliers), found)
    return found


def force_sizes(model: Model, force: int, t: Array, y: Array, multipliers: Array) -> Array:
    """Return the size (k,) of a force element along a coordinate [N, N m].

    Multipliers (k, n_c) are those of the states; only forces that read reactions need them.
    """
    t, y = _contiguous(t, y)
    found = np.zeros(t.size)
    _sizes(model, spare_work(model), force, t, y, np.ascontiguousarray(multipliers), found)
    return found


def marker_motions(model: Model, k: int, y: Array) -> tuple[Array, Array]:
    """Return the rows of motion.py (k, 24) and the Jacobians (k, 6, m + 6) of marker k."""
    y = np.ascontiguousarray(y)
    body = int(model.marker_body[k])
    n = 6 + int(model.n_mode[body]) if body >= 0 else 0
    motion, J_m = np.zeros((len(y), N_MOTION)), np.zeros((len(y), 6, n))
    if body >= 0:
        _motions(model, k, y, np.zeros((3, 3)), motion, J_m)
    elif len(y):
        stand(motion[0], model.marker_x[k], model.marker_A[k])
        motion[:] = motion[0]
    return motion, J_m


def _contiguous(t: Array, y: Array) -> tuple[Array, Array]:
    return np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(y, dtype=float)


@lean
def _derivatives(
    model: Model, work: Work, t: Array, y: Array, rates: Array, multipliers: Array, regular: Array
) -> None:
    for k in range(t.shape[0]):
        derivative_into(model, work, t[k], y[k], rates[k])
        regular[k] = work.factors.regular[0]
        for i in range(model.n_constraint):
            multipliers[k, i] = work.multipliers[i]


@lean
def _sizes(
    model: Model, work: Work, force: int, t: Array, y: Array, multipliers: Array, found: Array
) -> None:
    law, expression = model.force_law[force], model.quantities.force[force]
    for k in range(t.shape[0]):
        if law >= 0:
            found[k], _, _ = law_at(model, law, t[k])
        elif expression >= 0:
            for i in range(model.n_constraint):
                work.multipliers[i] = multipliers[k, i]
            evaluate(model, work, t[k], y[k])
            found[k] = work.size[force, 0]


@lean
def _balances(
    model: Model, work: Work, t: Array, y: Array, Phi: Array, Phi_d: Array, energies: Array
) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        evaluate_rates(model, work, y[k])
        for i in range(model.n_constraint):
            Phi[k, i], Phi_d[k, i] = work.rows[i, PHI], work.left[i]
        energies_into(model, work, y[k], energies[k])


@lean
def _momenta(model: Model, work: Work, t: Array, y: Array, found: Array) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        momenta_into(model, work, y[k], found[k])


@lean
def _masses(model: Model, work: Work, i: int, t: Array, y: Array, found: Array) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        for a in range(model.plan.size[i]):
            for b in range(a + 1):
                found[k, a, b] = found[k, b, a] = work.M[i, a, b]


@lean
def _loads(model: Model, work: Work, t: Array, y: Array, multipliers: Array, found: Array) -> None:
    n_joint, q = model.joint_kind.shape[0], model.quantities
    first = n_joint - n_coupling(model)
    for k in range(t.shape[0]):
        for i in range(model.n_constraint):
            work.multipliers[i] = multipliers[k, i]
        evaluate(model, work, t[k], y[k])
        for c in range(n_joint - first):
            push = multipliers[k, model.joint_row[first + c]]
            for term in range(q.coupling_start[c], q.coupling_start[c + 1]):
                at = 2 * (n_joint + model.force_kind.shape[0] + term)
                for a in range(6):
                    size = push * q.coupling_ratio[term]
                    found[k, at, a] = -size * work.g[q.coupling_coordinate[term], a]
                    found[k, at + 1, a] = -size * work.g[q.coupling_coordinate[term], 6 + a]
        for i in range(first):
            for row in range(model.joint_row[i], model.joint_row[i + 1]):
                for a in range(6):
                    found[k, 2 * i, a] -= work.rows[row, a] * multipliers[k, row]
                    found[k, 2 * i + 1, a] -= work.rows[row, 6 + a] * multipliers[k, row]
        for i in range(model.force_kind.shape[0]):
            one = work.motion[model.force_marker[i, 0]]
            two = work.motion[model.force_marker[i, 1]]
            wrench = force_wrench(model, work, i, t[k])
            arm = minus3(place(two), place(one))
            turn = cross3(arm, wrench.force)
            at = 2 * (n_joint + i)
            for a in range(3):
                found[k, at + 1, a] = wrench.force[a]
                found[k, at + 1, 3 + a] = wrench.moment[a]
                if model.force_kind[i] < FIRST_LOAD:
                    found[k, at, a] = -wrench.force[a]
                    found[k, at, 3 + a] = -wrench.moment[a] - turn[a]


@lean
def _motions(model: Model, marker: int, y: Array, A: Array, motion: Array, J_m: Array) -> None:
    p = model.pos_start[model.marker_body[marker]] + 3
    for k in range(y.shape[0]):
        rotation_into(y[k, p : p + 4], A)
        move_marker(model, marker, y[k], A, motion[k], J_m[k])
