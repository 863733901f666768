"""Evaluation of the equations of motion in one state: mass matrices, forces, constraints, energies.

At the end: auxiliary states, their start, and the instants at which controllers act or levels are
crossed.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, Triple, distinct
from ...math.compiled import inlined, lean
from ...math.expressions.program import NO_SEED, evaluated
from ...math.laws import Hermite
from ...math.rotations import cross3, dot3, minus3, rotation_into, sum3, times3, triple
from ..elements.floating_frame import (
    evaluate_bodies,
    inflate,
    largest,
    row_products,
    second_order_first_moment,
)
from ..elements.forces.contract import Wrench
from ..elements.forces.table import FIRST_LOAD, element_wrench
from ..elements.joints.table import joint_rows
from ..elements.marker import evaluate_markers
from ..model.model import (
    AXIAL,
    BENDING,
    GAMMA,
    PHI,
    PHI_T,
    RADIAL,
    Model,
    Workspace,
    spare_workspace,
)
from ..model.motion import axis, place
from ..tolerances import ONE_SAMPLE, REACTION_FOUND, REACTION_ROUNDING
from .laws import acceleration_of, auxiliary_rate, force_size, law_at, measure
from .rotor import PASSES, move_inflow, section_rates_into, section_wrench, wind_into


@inlined
def energies_into(model: Model, work: Workspace, y: Array, out: Array) -> None:
    """Fill out (3,) with the energies of state y, after an evaluation there; see `energies`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    out : kinetic, strain and potential energy (3,) [J], to fill
    """
    kinetic = 0.0
    for i in range(model.n_body):
        j, M, lead = model.n_pos + model.vel_start[i], work.M[i], model.layout.lead[i]
        for a in range(model.layout.size[i]):
            momentum = 0.5 * M[a, a] * y[j + a]
            for b in range(min(a, lead)):
                momentum += M[a, b] * y[j + b]
            kinetic += y[j + a] * momentum
    out[0] = kinetic
    stored_energies(model, y, work.P, out)
    out[2] += work.power[1]


@inlined
def momenta_into(model: Model, work: Workspace, y: Array, out: Array) -> None:
    """Fill out (n_vel,) with M v of state y, after an evaluation there.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    out : M v (n_vel,), to fill
    """
    for i in range(model.n_body):
        first, M = model.vel_start[i], work.M[i]
        j = model.n_pos + first
        for a in range(model.layout.size[i]):
            out[first + a] = 0.0
            for b in range(a + 1):
                out[first + a] += M[a, b] * y[j + b]
                if b < a:
                    out[first + b] += M[a, b] * y[j + a]


@lean
def stored_energies(model: Model, y: Array, A: Array, out: Array) -> None:
    """Fill strain energy and that of weight, out[1] and out[2] [J]; A (3, 3) is memory.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    A : memory (3, 3)
    out : energies (3,) [J]; entries 1 and 2 are filled
    """
    strain, weight = 0.0, 0.0
    for i in range(model.n_body):
        p, m = model.pos_start[i], model.n_mode[i]
        one, two = 3 * model.mode_start[i], model.square_start[i]
        second = 12 * model.second_start[i]
        stiffened = model.second_start[i + 1] > model.second_start[i]
        rotation_into(y[p + 3 : p + 7], A)
        for k in range(m):
            force = 0.0
            for j in range(m):
                force += model.K_qq[two + k * m + j] * y[p + 7 + j]
            strain += 0.5 * y[p + 7 + k] * force
        for b in range(3):
            first = model.S0[i, b]
            for k in range(m):
                first += model.S[one + b * m + k] * y[p + 7 + k]
                if stiffened:
                    for j in range(m):
                        Z = model.Z[second + (b * m + k) * m + j]
                        first += 0.5 * Z * y[p + 7 + k] * y[p + 7 + j]
            for a in range(3):
                weight -= model.gravity_G[a] * A[a, b] * first
        for a in range(3):
            weight -= model.gravity_G[a] * model.mass[i] * y[p + a]
    out[1], out[2] = strain, weight


def first_moments(model: Model, i: int, q: Array) -> Array:
    """Return the first moments of mass (k, 3) of body i about its frame, body axes [kg m].

    q (k, m) are its modal coordinates.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    i : number of the body
    q : its modal coordinates (k, m)
    """
    one, m = int(model.mode_start[i]), int(model.n_mode[i])
    S = model.S[3 * one : 3 * (one + m)].reshape(3, m)
    first = model.S0[i] + q @ S.T
    if model.second_start[i + 1] > model.second_start[i]:
        first = first + second_order_first_moment(model, i, q)
    return np.asarray(first)


@lean
def force_wrench(model: Model, work: Workspace, k: int, t: float) -> Wrench:
    """Wrench of force element k at time t, with the quantities and markers of `work`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    k : number of the force element
    t : time [s]
    """
    if model.rotor.section[k] >= 0:
        return section_wrench(model, work, k, model.rotor.section[k])
    size = 0.0
    if model.force_law[k] >= 0:
        size, _, _ = law_at(model, model.force_law[k], t)
    elif model.quantities.force[k] >= 0:
        force_size(model.quantities, k, t, work.quantity, work.size[k])
        size = work.size[k, 0]
    if model.quantities.along[k] >= 0:
        return coordinate_wrench(model, work, k, size)
    one = work.motion[model.force_marker[k, 0]]
    two = work.motion[model.force_marker[k, 1]]
    return element_wrench(model.force_kind[k], one, two, model.force_parameters[k], size)


@inlined
def coordinate_wrench(model: Model, work: Workspace, k: int, size: float) -> Wrench:
    """Wrench of force element k of a size along its coordinate.

    By the row of the coordinate: virtual work size g (v_1, w_1, v_2, w_2).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    k : number of the force element
    size : force along its coordinate [N, N m]
    """
    along = model.quantities.along[k]
    push = times3(size, triple(work.g[along, 6:9]))
    turn = times3(size, triple(work.g[along, 9:12]))
    return Wrench(push, turn, 0.0, size * work.quantity[2 * along + 1])


@inlined
def add_forces(model: Model, work: Workspace, t: float) -> None:
    """Add the force elements to f, their power and their stored energy.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    """
    if model.rotor.polar.shape[0] > 0:
        speed, _, _ = law_at(model, model.rotor.law[0], t)
        turned, _, _ = law_at(model, model.rotor.law[1], t)
        wind_into(model, work, speed, turned)
    for k in range(model.force_kind.shape[0]):
        add_wrench(model, work, k, force_wrench(model, work, k, t))


@inlined
def add_wrench(model: Model, work: Workspace, k: int, wrench: Wrench) -> None:
    """Add a wrench of force element k to f, its power and its stored energy.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    k : number of the force element
    wrench : force, moment, power and stored energy of the element
    """
    work.power[0] += wrench.power
    work.power[1] += wrench.potential
    _push(model, work, model.force_marker[k, 1], wrench.force, wrench.moment, 1.0)
    if model.force_kind[k] < FIRST_LOAD:
        one = work.motion[model.force_marker[k, 0]]
        two = work.motion[model.force_marker[k, 1]]
        arm = cross3(minus3(place(two), place(one)), wrench.force)
        moment = sum3(wrench.moment, arm)
        _push(model, work, model.force_marker[k, 0], wrench.force, moment, -1.0)


@inlined
def _push(
    model: Model, work: Workspace, k: int, force: Triple, moment: Triple, sign: float
) -> None:
    """Add force and moment, global components, times `sign` at marker k to f."""
    body = model.marker_body[k]
    if body < 0:
        return
    for j in range(model.layout.size[body]):
        for a in range(3):
            push = work.J_m[k, a, j] * force[a] + work.J_m[k, 3 + a, j] * moment[a]
            work.f[body, j] += sign * push


@inlined
def evaluate_joints(model: Model, work: Workspace, t: float) -> None:
    """Fill the rows of all joints and the Jacobians at the bodies.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    """
    rows, layout = work.rows, model.layout
    for k in range(model.joint_kind.shape[0] - n_coupling(model)):
        one = work.motion[model.joint_marker[k, 0]]
        two = work.motion[model.joint_marker[k, 1]]
        begin, end = model.joint_row[k], model.joint_row[k + 1]
        law = (0.0, 0.0, 0.0)
        if model.joint_law[k] >= 0:
            law = law_at(model, model.joint_law[k], t)
        joint_rows(rows, begin, model.joint_kind[k], one, two, law, model.joint_parameters[k])
        for side in range(2):
            body = model.marker_body[model.joint_marker[k, side]]
            if body >= 0:
                first, n = layout.side_row[k, side], layout.size[body]
                J_m = work.J_m[model.joint_marker[k, side]]
                fill_jacobian(work.J[body], first, rows[begin:end], 6 * side, J_m, n)


@inlined
def n_coupling(model: Model) -> int:
    """Return how many of the joints, the last ones, are couplings of coordinates."""
    return int(model.quantities.coupling_start.shape[0] - 1)


@lean
def evaluate_couplings(model: Model, work: Workspace) -> None:
    """Fill the rows of couplings, sum r e = 0, and their columns of the Jacobians.

    The coefficients C of a row are those of its first coordinate.
    """
    q, layout, rows = model.quantities, model.layout, work.rows
    first = model.joint_kind.shape[0] - n_coupling(model)
    for c in range(n_coupling(model)):
        row, begin, end = model.joint_row[first + c], q.coupling_start[c], q.coupling_start[c + 1]
        for j in range(rows.shape[1]):
            rows[row, j] = 0.0
        for term in range(begin, end):
            m = q.coupling_coordinate[term]
            for side in range(2):
                column, body = (
                    layout.coupling_column[term, side],
                    model.marker_body[q.marker[m, side]],
                )
                if column >= 0:
                    for b in range(layout.size[body]):
                        work.J[body, b, column] = 0.0
        for term in range(begin, end):
            m, r = q.coupling_coordinate[term], q.coupling_ratio[term]
            one, two = work.motion[q.marker[m, 0]], work.motion[q.marker[m, 1]]
            rows[row, PHI] += r * work.quantity[2 * m]
            rows[row, GAMMA] -= r * acceleration_of(q.kind[m], q.axes[m], one, two)
            if term == begin:
                for j in range(12):
                    rows[row, j] = r * work.g[m, j]
            for side in range(2):
                column, marker = layout.coupling_column[term, side], q.marker[m, side]
                if column >= 0:
                    body = model.marker_body[marker]
                    for b in range(layout.size[body]):
                        for a in range(6):
                            push = r * work.g[m, 6 * side + a]
                            work.J[body, b, column] += push * work.J_m[marker, a, b]


@inlined
def fill_jacobian(J: Array, first: int, C: Array, begin: int, J_m: Array, n: int) -> None:
    """J (n, r) from column `first`: C of one side times the marker's Jacobian, transposed.

    Most rows hold either a displacement or a rotation: the other half of their product is zero.

    Parameters
    ----------
    J : Jacobian of the body (n, r), to fill
    first : first column
    C : rows of the joint, coefficients of velocities
    begin : first coefficient of this side, 0 or 6
    J_m : Jacobian of the marker (6, n)
    n : number of velocities of the body
    """
    for p in range(C.shape[0]):
        v0, v1, v2 = C[p, begin], C[p, begin + 1], C[p, begin + 2]
        w0, w1, w2 = C[p, begin + 3], C[p, begin + 4], C[p, begin + 5]
        column = first + p
        if w0 == 0.0 and w1 == 0.0 and w2 == 0.0:
            for j in range(n):
                J[j, column] = v0 * J_m[0, j] + v1 * J_m[1, j] + v2 * J_m[2, j]
        elif v0 == 0.0 and v1 == 0.0 and v2 == 0.0:
            for j in range(n):
                J[j, column] = w0 * J_m[3, j] + w1 * J_m[4, j] + w2 * J_m[5, j]
        else:
            for j in range(n):
                J[j, column] = (
                    v0 * J_m[0, j]
                    + v1 * J_m[1, j]
                    + v2 * J_m[2, j]
                    + w0 * J_m[3, j]
                    + w1 * J_m[4, j]
                    + w2 * J_m[5, j]
                )


MOST_PASSES = 60


@inlined
def reaction_slope(model: Model, work: Workspace, r: int, row: int) -> float:
    """Return the derivative of size r of a reaction by multiplier `row` of its joint.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    r : number of the reaction
    row : row of a multiplier of its joint
    """
    load, unit, n = _load(model, work, r), _load_of(model, work, r, row), _axis(model, work, r)
    along = dot3(load, n)
    if model.quantities.reaction_kind[r] in (RADIAL, BENDING):
        across = minus3(load, times3(along, n))
        size = float(np.sqrt(dot3(across, across)))
        return dot3(across, unit) / size if size > 0.0 else 0.0
    return dot3(n, unit) if along > 0.0 else -dot3(n, unit)


@lean
def reactions_into(model: Model, work: Workspace) -> None:
    """Fill the sizes of reactions in work.quantity from the rows and work.multipliers."""
    q = model.quantities
    first = work.quantity.shape[0] - q.reaction_kind.shape[0]
    for r in range(q.reaction_kind.shape[0]):
        load, n = _load(model, work, r), _axis(model, work, r)
        work.quantity[first + r] = _size(q.reaction_kind[r], load, n)


@inlined
def _load(model: Model, work: Workspace, r: int) -> Triple:
    """Return the force or moment of reaction r at work.multipliers."""
    joint, load = model.quantities.reaction_joint[r], (0.0, 0.0, 0.0)
    for row in range(model.joint_row[joint], model.joint_row[joint + 1]):
        load = sum3(load, times3(work.multipliers[row], _load_of(model, work, r, row)))
    return load


@inlined
def _load_of(model: Model, work: Workspace, r: int, row: int) -> Triple:
    """Return the force or moment of reaction r of a unit of multiplier `row`."""
    begin = 6 if model.quantities.reaction_kind[r] in (RADIAL, AXIAL) else 9
    return times3(-1.0, triple(work.rows[row, begin:]))


@inlined
def _axis(model: Model, work: Workspace, r: int) -> Triple:
    """Return the axis of the joint of reaction r."""
    joint = model.quantities.reaction_joint[r]
    return axis(work.motion[model.joint_marker[joint, 0]], 2)


@inlined
def _size(kind: int, load: Triple, n: Triple) -> float:
    """Return the size of a load across the axis n, or along it."""
    along = dot3(load, n)
    if kind in (RADIAL, BENDING):
        across = minus3(load, times3(along, n))
        return float(np.sqrt(dot3(across, across)))
    return abs(along)


@lean
def move_forces(model: Model, work: Workspace, t: float, passed: int) -> bool:
    """Move forces that read reactions to those at work.multipliers; return whether they differ.

    Their sizes, work.f and the power follow. `passed` is the number of calls before, for the same
    evaluation.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    passed : number of calls before, for the same evaluation
    """
    q, left = model.quantities, work.unsettled
    last = left.shape[0] - 1
    reactions_into(model, work)
    largest = 0.0
    for k in range(work.multipliers.shape[0]):
        largest = max(largest, abs(work.multipliers[k]))
    differ, product, square = False, 0.0, 0.0
    for k in q.reacting:
        before = work.size[k, 0]
        force_size(q, k, t, work.quantity, work.size[k])
        missing = work.size[k, 0] - before
        work.size[k, 0] = before
        # not-a-number differs
        if not abs(missing) <= REACTION_FOUND * abs(before) + REACTION_ROUNDING * largest:
            differ = True
        change = missing - left[k, 0]
        product += left[k, 0] * change
        square += change * change
        left[k, 0] = missing
    relax = 1.0
    if passed > 0 and square > 0.0:
        relax = -left[last, 0] * product / square
    left[last, 0] = relax
    if differ:
        for k in q.reacting:
            more = relax * left[k, 0]
            work.size[k, 0] += more
            add_wrench(model, work, k, coordinate_wrench(model, work, k, more))
    return differ


@lean
def evaluate(model: Model, work: Workspace, t: float, y: Array) -> None:
    """Fill mass matrices, forces and constraints at time t and state y; nothing is allocated.

    Forces that read reactions are those at work.multipliers.

    Paper: Eq. (5), Eq. (6), Eq. (8), Eq. (9), Eq. (12) with the sign of s of Eq. (6):
    M a + Phi_q' lambda = f.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    work.power[0] = work.power[1] = 0.0
    evaluate_bodies(model, work, y)
    evaluate_markers(model, work, y)
    measure_into(model, work, y)
    evaluate_joints(model, work, t)
    if model.quantities.coupling_ratio.shape[0] > 0:
        evaluate_couplings(model, work)
    if reads_reactions(model):
        reactions_into(model, work)
    add_forces(model, work, t)


@inlined
def reads_reactions(model: Model) -> bool:
    """Return whether forces or states read the reactions of joints."""
    return bool(model.quantities.reaction_kind.shape[0] > 0)


@inlined
def measure_into(model: Model, work: Workspace, y: Array) -> None:
    """Fill the quantities that expressions read, in state y with these markers.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    """
    if work.quantity.shape[0] > 0:
        first = model.n_pos + model.n_vel
        measure(model.quantities, work.motion, y, first, work.quantity, work.g)


@inlined
def auxiliary_rates_into(model: Model, work: Workspace, t: float, out: Array) -> None:
    """Fill the rates of the auxiliary states of the last evaluation in out (n,).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    out : dy/dt (n,), filled at the auxiliary states
    """
    first = model.n_pos + model.n_vel
    for j in range(model.n_aux):
        out[first + j], _ = auxiliary_rate(model.quantities, j, t, work.quantity)
    section_rates_into(model, work, out)


@inlined
def largest_left(model: Model, work: Workspace, J: Array, x: Array) -> float:
    """Largest row of Phi + Phi_q x: above round-off if rows contradict each other.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    J : Jacobians by bodies (nb, n, r)
    x : change of positions by bodies (nb, n)
    """
    row_products(model, J, x, work.left)
    for k in range(model.n_constraint):
        work.left[k] += work.rows[k, PHI]
    return largest(work.left)


@inlined
def evaluate_rates(model: Model, work: Workspace, y: Array) -> None:
    """Fill work.left with Phidot (n_c,) in state y, of the last evaluation.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    """
    inflate(model, y, model.n_pos, work.acceleration)
    row_products(model, work.J, work.acceleration, work.left)
    for k in range(model.n_constraint):
        work.left[k] += work.rows[k, PHI_T]


_PARTS = np.linspace(0.0, 1.0, 9)


def beyond(model: Model, t: float, y: Array) -> Array:
    """Return how far each coordinate is beyond its level, and the rate of that, (ne, 2).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    q, work = model.quantities, spare_workspace(model)
    evaluate(model, work, t, y)
    at, sign = q.event_coordinate, q.event_sign
    gap = sign * (work.quantity[2 * at] - q.event_level)
    return np.column_stack([gap, sign * work.quantity[2 * at + 1]])


def first_crossing(
    model: Model, t: Array, y: Array, armed: tuple[bool, ...]
) -> tuple[tuple[bool, ...], int, float]:
    """Look for the first event in steps with the ends t (k + 1,), y (k + 1, n).

    Returns `armed` before that instant, the event, and the instant [s]; -1 without one. Between
    ends of a step coordinates are cubics by values and rates.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : ends of the steps (k + 1,) [s]
    y : states there (k + 1, n)
    armed : of each event, whether its coordinate has been before its level since the last time
    """
    ready = np.array(armed)
    before = beyond(model, float(t[0]), y[0])
    for i in range(1, len(t)):
        after, h = beyond(model, float(t[i]), y[i]), float(t[i] - t[i - 1])
        gap = Hermite(0.0, 1.0, before[:, 0], h * before[:, 1], after[:, 0], h * after[:, 1])
        passed = (gap(_PARTS) > 0.0) & ready
        crossings = [
            (_root(gap, e, int(passed[:, e].argmax())), e)
            for e in np.flatnonzero(passed.any(axis=0)).tolist()
        ]
        if crossings:
            share, e = min(crossings)
            return tuple(ready.tolist()), e, float(t[i - 1]) + share * h
        ready |= after[:, 0] < 0.0
        before = after
    return tuple(ready.tolist()), -1, 0.0


def _root(gap: Hermite, e: int, k: int) -> float:
    """Return the part of a step at which gap e first is positive; it is at part k of `_PARTS`."""
    low, high = (float(_PARTS[k - 1]), float(_PARTS[k])) if k else (0.0, 0.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if gap(middle)[e] > 0.0:
            high = middle
        else:
            low = middle
    return high


Called = Callable[[float, Array], float]


def started(model: Model, t: float, y: Array) -> Array:
    """Return the state y (n,) with the auxiliary states that a run starts with at time t.

    Angles are those of the position, within half a turn of what stood there; the others follow
    from their expressions, in their order; the inflow of a rotor is steady.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    if model.n_aux == 0:
        return y
    y, work, q = y.copy(), spare_workspace(model), model.quantities
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)
    for m in np.flatnonzero(q.turn >= 0):
        y[first + q.turn[m]] = work.quantity[2 * m]
    for j in np.flatnonzero(q.start_expression >= 0):
        measure_into(model, work, y)
        p = int(q.start_expression[j])
        y[first + j] = evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]
    for _ in range(PASSES if model.rotor.polar.size else 0):
        evaluate(model, work, t, y)
        if move_inflow(model, work.flow, y):
            break
    return sampled(model, t, y, q.period > 0.0)


def sampled(
    model: Model, t: float, y: Array, which: NDArray[np.bool_], functions: Sequence[Called] = ()
) -> Array:
    """Return the state y (n,) after the auxiliary states `which` (na,) have been sampled at t.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    which : states to sample (na,)
    functions : of the states `quantities.called`, of time and inputs (k,); without them these keep
        their values
    """
    q, work, after = model.quantities, spare_workspace(model), y.copy()
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)

    def value(p: int) -> float:
        return evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]

    for c, function in enumerate(functions):
        if which[q.called[c]]:
            inputs = [value(p) for p in range(*q.call_start[c : c + 2].tolist())]
            after[first + q.called[c]] = function(t, np.array(inputs))
    for j in np.flatnonzero(which & (q.update >= 0)):
        after[first + j] = value(int(q.update[j]))
    return after


@inlined
def is_sampled(period: float, t: float) -> bool:
    """Return whether a state of a period [s], 0 for none, is sampled at the instant t [s]."""
    return period > 0.0 and abs(t / period - np.round(t / period)) < ONE_SAMPLE


class Instants:
    """When the auxiliary states of a model are sampled, behind `begin` and before t_end [s].

    An instant a rounding error behind `begin` is that of the begin itself, and not among them.

    Attributes
    ----------
    t : (k,) [s]
    """

    def __init__(self, model: Model, t_end: float, begin: float = 0.0) -> None:
        self._period = model.quantities.period
        if not (self._period > 0.0).any():
            self.t: Array = np.zeros(0)
            return
        periods = distinct(self._period[self._period > 0.0])
        all_t = [
            p * np.arange(int(begin / p + ONE_SAMPLE) + 1, int(np.ceil(t_end / p - ONE_SAMPLE)))
            for p in periods
        ]
        t = np.sort(np.concatenate([np.zeros(0), *all_t]))
        apart = np.diff(t, prepend=-1.0) > ONE_SAMPLE * periods.min(initial=1.0)
        self.t = t[apart]

    def sampled_at(self, t: float) -> NDArray[np.bool_]:
        """Return which auxiliary states (na,) are sampled at an instant t."""
        return np.array([is_sampled(p, t) for p in self._period.tolist()], dtype=bool)
