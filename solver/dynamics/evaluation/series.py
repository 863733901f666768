"""Evaluations of many states in one call: what signals and checks need at the output times.

All functions take times t (k,) and states y (k, n) and return arrays whose first axis is k; memory
and time are linear in k.
"""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array, IntArray
from ...math.compiled import lean
from ...math.rotations import cross3, minus3, rotation_into, triple, turned
from ..elements.floating_frame import evaluate_bodies
from ..elements.forces.table import FIRST_LOAD
from ..elements.marker import move_marker
from ..model.model import PHI, PHI_T, Model, Workspace, spare_workspace, state_size
from ..model.motion import N_MOTION, PLACE, place, stand
from ..tolerances import REGULAR
from .accelerations import by_blocks, dense_derivative_into, derivative_into
from .elimination import is_tree
from .energies import energies_into, momenta_into
from .evaluation import evaluate, evaluate_rates, force_wrench, n_coupling
from .laws import law_at


class Balance(NamedTuple):
    """Constraints and energies of k states."""

    Phi: Array  # (k, n_c)
    Phi_d: Array  # (k, n_c) its rate
    energies: Array  # (k, 3) kinetic, strain, potential [J]


class Along(NamedTuple):
    """The equations of motion in k states."""

    rates: Array  # (k, n) dy/dt
    multipliers: Array  # (k, n_c)
    balance: Balance


def along_solution(
    model: Model, t: Array, y: Array, regular_above: float = REGULAR
) -> tuple[Array, Array]:
    """Return dy/dt (k, n) and the multipliers (k, n_c); see `along`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    regular_above : least pivot above which elimination is used
    """
    rates, multipliers, _ = along(model, t, y, regular_above)
    return rates, multipliers


def along(model: Model, t: Array, y: Array, regular_above: float = REGULAR) -> Along:
    """Return rates, multipliers, constraints and energies of states. Paper: Eq. (14).

    The rates are those that are integrated. Multipliers of redundant constraints are those of
    least norm; with the augmented Lagrangian, those of the equations without it, so that the
    balance of momentum shows whether its iteration has converged.

    Below `regular_above`, the least pivot over its diagonal entry, states are solved with dense
    matrices, in the third power of the number of bodies.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    regular_above : least pivot, over its diagonal entry, above which elimination is used
    """
    t, y = _contiguous(t, y)
    result, regular = _evaluated(model, t, y, solve=by_blocks(model))
    # Rows that nearly depend on each other: elimination loses digits that pivoting keeps.
    doubtful = regular < regular_above
    if model.redundant == 0 and doubtful.any() and is_tree(model):
        doubtful[:] = False
    if model.penalty > 0.0 and model.beta > 0.0:
        doubtful[:] = True
    work, spare = spare_workspace(model), np.zeros(state_size(model))
    for k in np.flatnonzero(doubtful).tolist():
        into = result.rates[k] if model.penalty == 0.0 else spare
        result.multipliers[k] = dense_derivative_into(model, work, float(t[k]), y[k], into)
    return result


def balance(model: Model, t: Array, y: Array) -> Balance:
    """Return constraints and energies.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    """
    result, _ = _evaluated(model, *_contiguous(t, y), solve=False)
    return result.balance


def momenta(model: Model, y: Array) -> tuple[Array, Array]:
    """Return M v (k, n_vel), and the momenta of the bodies (k, nb, 6) [kg m/s, kg m2/s].

    The latter are linear momentum and angular momentum about the global origin, global components.
    They follow from the mass matrix alone; point masses belong to the bodies that carry them.
    """
    y = np.ascontiguousarray(y, dtype=float)
    own, momentum = np.zeros((len(y), model.n_vel)), np.zeros((len(y), model.n_body, 6))
    _momenta(model, spare_workspace(model), y, own, momentum)
    return own, momentum


def driven_speeds(model: Model, t: Array, y: Array) -> Array:
    """Return how fast laws of time move the constraints of one state y (n,), (k, n_c).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : one state (n,)
    """
    speeds = np.zeros((t.size, model.n_constraint))
    _driven_speeds(model, spare_workspace(model), t, np.ascontiguousarray(y), speeds)
    return speeds


def mass_matrices(model: Model, i: int, t: Array, y: Array) -> Array:
    """Return the mass matrix of body i, (k, m + 6, m + 6).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    i : number of the body
    t : times (k,) [s]
    y : states (k, n)
    """
    t, y = _contiguous(t, y)
    n = int(model.layout.size[i])
    M = np.zeros((t.size, n, n))
    _masses(model, spare_workspace(model), i, t, y, M)
    return M


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

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    multipliers : multipliers of the constraints (k, n_c)
    """
    return loads_of_markers(model, t, y, multipliers)[0]


def marker_places(model: Model, y: Array) -> Array:
    """Return the origins of all markers (nk, 3) in one state y (n,), global [m]."""
    places = np.array(model.marker_x)  # those of the ground
    J_m = np.zeros((6, model.layout.widest))
    _places(model, np.ascontiguousarray(y), np.zeros((3, 3)), np.zeros(N_MOTION), J_m, places)
    return places


def loads_of_markers(model: Model, t: Array, y: Array, multipliers: Array) -> tuple[Array, Array]:
    """Return the loads of `marker_loads`, and the origins of their markers (k, n, 3) [m].

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    multipliers : multipliers of the constraints (k, n_c)
    """
    t, y = _contiguous(t, y)
    markers = loaded_markers(model)
    loads, origins = np.zeros((t.size, markers.size, 6)), np.zeros((t.size, markers.size, 3))
    multipliers = np.ascontiguousarray(multipliers)
    _loads(model, spare_workspace(model), markers, t, y, multipliers, loads, origins)
    return loads, origins


def force_sizes(model: Model, force: int, t: Array, y: Array, multipliers: Array) -> Array:
    """Return the size (k,) of a force element along a coordinate [N, N m].

    Multipliers (k, n_c) are those of the states; only forces that read reactions need them.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    force : number of the force element
    t : times (k,) [s]
    y : states (k, n)
    multipliers : multipliers of the constraints (k, n_c)
    """
    t, y = _contiguous(t, y)
    sizes = np.zeros(t.size)
    _sizes(model, spare_workspace(model), force, t, y, np.ascontiguousarray(multipliers), sizes)
    return sizes


def quantities(model: Model, t: Array, y: Array) -> Array:
    """Return what expressions read (model/model.py), (k, n); reactions are those of before.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    """
    t, y = _contiguous(t, y)
    work = spare_workspace(model)
    values = np.zeros((t.size, work.quantity.size))
    _quantities(model, work, t, y, values)
    return values


def marker_motions(model: Model, k: int, y: Array) -> tuple[Array, Array]:
    """Return the rows of motion.py (k, 24) and the Jacobians (k, 6, m + 6) of marker k.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    k : number of the marker
    y : states (k, n)
    """
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


def _evaluated(model: Model, t: Array, y: Array, *, solve: bool) -> tuple[Along, Array]:
    """Evaluate states, and `solve` for rates and multipliers; return least pivots (k,) too."""
    k, n_c = t.size, model.n_constraint
    rates, multipliers, regular = np.zeros(y.shape), np.zeros((k, n_c)), np.zeros(k)
    terms = Balance(np.zeros((k, n_c)), np.zeros((k, n_c)), np.zeros((k, 3)))
    work = spare_workspace(model)
    _evaluations(model, work, t, y, solve, rates, multipliers, regular, *terms)
    return Along(rates, multipliers, terms), regular


def _contiguous(t: Array, y: Array) -> tuple[Array, Array]:
    return np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(y, dtype=float)


@lean
def _evaluations(
    model: Model,
    work: Workspace,
    t: Array,
    y: Array,
    solve: bool,
    rates: Array,
    multipliers: Array,
    regular: Array,
    Phi: Array,
    Phi_d: Array,
    energies: Array,
) -> None:
    for k in range(t.shape[0]):
        if solve:
            derivative_into(model, work, t[k], y[k], rates[k])
            regular[k] = work.factors.regular[0]
            for i in range(model.n_constraint):
                multipliers[k, i] = work.multipliers[i]
        else:
            evaluate(model, work, t[k], y[k])
        evaluate_rates(model, work, y[k])
        for i in range(model.n_constraint):
            Phi[k, i], Phi_d[k, i] = work.rows[i, PHI], work.left[i]
        energies_into(model, work, y[k], energies[k])


@lean
def _sizes(
    model: Model, work: Workspace, force: int, t: Array, y: Array, multipliers: Array, sizes: Array
) -> None:
    law, expression = model.force_law[force], model.quantities.force[force]
    for k in range(t.shape[0]):
        if law >= 0:
            sizes[k], _, _ = law_at(model, law, t[k])
        elif expression >= 0:
            for i in range(model.n_constraint):
                work.multipliers[i] = multipliers[k, i]
            evaluate(model, work, t[k], y[k])
            sizes[k] = work.size[force, 0]


@lean
def _momenta(model: Model, work: Workspace, y: Array, own: Array, momentum: Array) -> None:
    for k in range(y.shape[0]):
        evaluate_bodies(model, work, y[k])
        momenta_into(model, work, y[k], own[k])
        for i in range(model.n_body):
            a, j = model.pos_start[i], model.vel_start[i]
            linear = triple(own[k, j : j + 3])
            orbit = cross3(triple(y[k, a : a + 3]), linear)
            spin = turned(work.A[i], triple(own[k, j + 3 : j + 6]))
            for c in range(3):
                momentum[k, i, c], momentum[k, i, 3 + c] = linear[c], orbit[c] + spin[c]


@lean
def _driven_speeds(model: Model, work: Workspace, t: Array, y: Array, speeds: Array) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y)
        for i in range(model.n_constraint):
            speeds[k, i] = work.rows[i, PHI_T]


@lean
def _quantities(model: Model, work: Workspace, t: Array, y: Array, values: Array) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        for j in range(values.shape[1]):
            values[k, j] = work.quantity[j]


@lean
def _masses(model: Model, work: Workspace, i: int, t: Array, y: Array, M: Array) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        for a in range(model.layout.size[i]):
            for b in range(a + 1):
                M[k, a, b] = M[k, b, a] = work.M[i, a, b]


@lean
def _loads(
    model: Model,
    work: Workspace,
    markers: IntArray,
    t: Array,
    y: Array,
    multipliers: Array,
    loads: Array,
    origins: Array,
) -> None:
    n_joint, q = model.joint_kind.shape[0], model.quantities
    first = n_joint - n_coupling(model)
    for k in range(t.shape[0]):
        for i in range(model.n_constraint):
            work.multipliers[i] = multipliers[k, i]
        evaluate(model, work, t[k], y[k])
        for i in range(markers.shape[0]):
            for a in range(3):
                origins[k, i, a] = work.motion[markers[i], PLACE + a]
        for c in range(n_joint - first):
            push = multipliers[k, model.joint_row[first + c]]
            for term in range(q.coupling_start[c], q.coupling_start[c + 1]):
                at = 2 * (n_joint + model.force_kind.shape[0] + term)
                for a in range(6):
                    size = push * q.coupling_ratio[term]
                    loads[k, at, a] = -size * work.g[q.coupling_coordinate[term], a]
                    loads[k, at + 1, a] = -size * work.g[q.coupling_coordinate[term], 6 + a]
        for i in range(first):
            for row in range(model.joint_row[i], model.joint_row[i + 1]):
                for a in range(6):
                    loads[k, 2 * i, a] -= work.rows[row, a] * multipliers[k, row]
                    loads[k, 2 * i + 1, a] -= work.rows[row, 6 + a] * multipliers[k, row]
        for i in range(model.force_kind.shape[0]):
            one = work.motion[model.force_marker[i, 0]]
            two = work.motion[model.force_marker[i, 1]]
            wrench = force_wrench(model, work, i, t[k])
            arm = minus3(place(two), place(one))
            turn = cross3(arm, wrench.force)
            at = 2 * (n_joint + i)
            for a in range(3):
                loads[k, at + 1, a] = wrench.force[a]
                loads[k, at + 1, 3 + a] = wrench.moment[a]
                if model.force_kind[i] < FIRST_LOAD:
                    loads[k, at, a] = -wrench.force[a]
                    loads[k, at, 3 + a] = -wrench.moment[a] - turn[a]


@lean
def _motions(model: Model, marker: int, y: Array, A: Array, motion: Array, J_m: Array) -> None:
    p = model.pos_start[model.marker_body[marker]] + 3
    for k in range(y.shape[0]):
        rotation_into(y[k, p : p + 4], A)
        move_marker(model, marker, y[k], A, motion[k], J_m[k])


@lean
def _places(model: Model, y: Array, A: Array, motion: Array, J_m: Array, places: Array) -> None:
    for k in range(model.marker_body.shape[0]):
        body = model.marker_body[k]
        if body >= 0:
            p = model.pos_start[body] + 3
            rotation_into(y[p : p + 4], A)
            move_marker(model, k, y, A, motion, J_m)
            for a in range(3):
                places[k, a] = motion[PLACE + a]
