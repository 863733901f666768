"""Evaluation of the equations of motion in one state: mass matrices, forces, constraints."""

import numpy as np

from ...math.arrays import Array, Triple
from ...math.compiled import inlined, lean
from ...math.rotations import cross3, minus3, sum3, times3, triple
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
    GAMMA,
    PHI,
    PHI_T,
    Model,
    Workspace,
)
from ..model.motion import place
from ..tolerances import REACTION_FOUND, REACTION_ROUNDING
from .laws import acceleration_of, auxiliary_rate, force_size, law_at, measure
from .reactions import reactions_into, reads_reactions
from .rotor import section_rates_into, section_wrench, wind_into


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
