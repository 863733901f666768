"""Equations of motion of the whole system and their solution for accelerations."""

from typing import NamedTuple

import numpy as np

from ..math.arrays import Array
from ..math.compiled import inlined, lean
from ..math.laws import law_value
from ..math.triple import Triple, cross3, minus3, sum3, times3, triple
from .bodies.floating_frame import evaluate_bodies
from .bodies.marker import evaluate_markers
from .bodies.motion import place
from .constraints.augmented_lagrangian import augmented_lagrangian
from .constraints.baumgarte import stabilised
from .constraints.minimum_norm import minimum_norm
from .constraints.saddle_point import saddle_point
from .coordinates import rates_into
from .dependence import REGULAR, rows_depend
from .elimination import factorise, solve
from .energy import stored_energies
from .forces.contract import Wrench
from .forces.table import FIRST_LOAD, element_wrench
from .joints.table import joint_rows
from .measures import acceleration_of, auxiliary_rate, force_size, law_of_time, measure
from .model import Model, state_size
from .settling import MOST_PASSES, move_forces, reactions_into
from .workspace import GAMMA, PHI, PHI_T, Work, spare_work


class Equations(NamedTuple):
    """One evaluation of the equations of motion at (t, y), as dense arrays."""

    M: Array  # (n_vel, n_vel) mass matrix
    f: Array  # (n_vel,) loads, quadratic velocity terms, elastic and damping forces
    Phi_q: Array  # (n_c, n_vel) d Phidot / d velocities
    C: Array  # (n_c, 12) the same by the velocities of each joint's two markers (joints/rows.py)
    Phi: Array  # (n_c,)
    Phi_t: Array  # (n_c,)
    gamma: Array  # (n_c,) gamma* of Eq. (11)
    power: Array  # (1,) of dampers, actuators and loads [W]
    potential: Array  # (1,) energy stored in force elements [J]


@lean
def evaluate(model: Model, work: Work, t: float, y: Array) -> None:
    """Fill mass matrices, forces and constraints at time t and state y; nothing is allocated.

    Forces that read reactions are those at work.multipliers.

    Paper: Eq. (5), Eq. (6), Eq. (8), Eq. (9), Eq. (12) with the sign of s of Eq. (6):
    M a + Phi_q' lambda = f.
    """
    work.power[0] = work.power[1] = 0.0
    evaluate_bodies(model, work, y)
    evaluate_markers(model, work, y)
    measure_into(model, work, y)
    _evaluate_joints(model, work, t)
    if model.quantities.coupling_ratio.shape[0] > 0:
        _evaluate_couplings(model, work)
    if reads_reactions(model):
        reactions_into(model, work)
    _add_forces(model, work, t)


@inlined
def _evaluate_joints(model: Model, work: Work, t: float) -> None:
    """Fill the rows of all joints and the Jacobians at the bodies."""
    rows, plan = work.rows, model.plan
    for k in range(model.joint_kind.shape[0] - n_coupling(model)):
        one = work.motion[model.joint_marker[k, 0]]
        two = work.motion[model.joint_marker[k, 1]]
        begin, end = model.joint_row[k], model.joint_row[k + 1]
        drive, drive_d, drive_dd = 0.0, 0.0, 0.0
        if model.joint_law[k] >= 0:
            drive, drive_d, drive_dd = law_at(model, model.joint_law[k], t)
        joint_rows(
            rows,
            begin,
            model.joint_kind[k],
            one,
            two,
            drive,
            drive_d,
            drive_dd,
            model.joint_parameters[k],
        )
        for side in range(2):
            body = model.marker_body[model.joint_marker[k, side]]
            if body >= 0:
                first, n = plan.side_row[k, side], plan.size[body]
                J_m = work.J_m[model.joint_marker[k, side]]
                fill_jacobian(work.J[body], first, rows[begin:end], 6 * side, J_m, n)


@inlined
def reads_reactions(model: Model) -> bool:
    """Tell whether forces or states read the reactions of joints."""
    return bool(model.quantities.reaction_kind.shape[0] > 0)


@inlined
def n_coupling(model: Model) -> int:
    """Return how many of the joints, the last ones, are couplings of coordinates."""
    return int(model.quantities.coupling_start.shape[0] - 1)


@lean
def _evaluate_couplings(model: Model, work: Work) -> None:
    """Fill the rows of couplings, sum r e = 0, and their columns of the Jacobians.

    The coefficients C of a row are those of its first coordinate.
    """
    q, plan, rows = model.quantities, model.plan, work.rows
    first = model.joint_kind.shape[0] - n_coupling(model)
    for c in range(n_coupling(model)):
        row, begin, end = model.joint_row[first + c], q.coupling_start[c], q.coupling_start[c + 1]
        for j in range(rows.shape[1]):
            rows[row, j] = 0.0
        for term in range(begin, end):
            m = q.coupling_coordinate[term]
            for side in range(2):
                column, body = (
                    plan.coupling_column[term, side],
                    model.marker_body[q.marker[m, side]],
                )
                if column >= 0:
                    for b in range(plan.size[body]):
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
                column, marker = plan.coupling_column[term, side], q.marker[m, side]
                if column >= 0:
                    body = model.marker_body[marker]
                    for b in range(plan.size[body]):
                        for a in range(6):
                            push = r * work.g[m, 6 * side + a]
                            work.J[body, b, column] += push * work.J_m[marker, a, b]


@inlined
def fill_jacobian(J: Array, first: int, C: Array, begin: int, J_m: Array, n: int) -> None:
    """J (n, r) from column `first`: C of one side times the marker's Jacobian, transposed.

    Most rows hold either a displacement or a rotation: the other half of their product is zero.
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


@inlined
def law_at(model: Model, law: int, t: float) -> tuple[float, float, float]:
    """Value and rates of a law at t; zeros where there is none."""
    if law < 0:
        return 0.0, 0.0, 0.0
    if model.quantities.law[law] >= 0:
        return law_of_time(model.quantities, model.quantities.law[law], t)
    return law_value(model.law_start, model.law_time, model.law_coefficient, law, t)


@inlined
def measure_into(model: Model, work: Work, y: Array) -> None:
    """Fill the quantities that expressions read, in state y with these markers."""
    if work.quantity.shape[0] > 0:
        first = model.n_pos + model.n_vel
        measure(model.quantities, work.motion, y, first, work.quantity, work.g)


@inlined
def auxiliary_rates_into(model: Model, work: Work, t: float, out: Array) -> None:
    """Fill the rates of the auxiliary states of the last evaluation in out (n,)."""
    first = model.n_pos + model.n_vel
    for j in range(model.n_aux):
        out[first + j], _ = auxiliary_rate(model.quantities, j, t, work.quantity)


@lean
def force_wrench(model: Model, work: Work, k: int, t: float) -> Wrench:
    """Wrench of force element k at time t, with the quantities and markers of `work`."""
    along, size = model.quantities.along[k], 0.0
    if model.force_law[k] >= 0:
        size, _, _ = law_at(model, model.force_law[k], t)
    elif model.quantities.force[k] >= 0:
        force_size(model.quantities, k, t, work.quantity, work.size[k])
        size = work.size[k, 0]
    if along >= 0:  # the row of a coordinate: virtual work size g (v_1, w_1, v_2, w_2)
        push = times3(size, triple(work.g[along, 6:9]))
        turn = times3(size, triple(work.g[along, 9:12]))
        return Wrench(push, turn, 0.0, size * work.quantity[2 * along + 1])
    one = work.motion[model.force_marker[k, 0]]
    two = work.motion[model.force_marker[k, 1]]
    return element_wrench(model.force_kind[k], one, two, model.force_parameters[k], size)


@inlined
def _add_forces(model: Model, work: Work, t: float) -> None:
    """Add the force elements to f, their power and their stored energy."""
    for k in range(model.force_kind.shape[0]):
        one = work.motion[model.force_marker[k, 0]]
        two = work.motion[model.force_marker[k, 1]]
        wrench = force_wrench(model, work, k, t)
        work.power[0] += wrench.power
        work.power[1] += wrench.potential
        _push(model, work, model.force_marker[k, 1], wrench.force, wrench.moment, 1.0)
        if model.force_kind[k] < FIRST_LOAD:
            arm = cross3(minus3(place(two), place(one)), wrench.force)
            moment = sum3(wrench.moment, arm)
            _push(model, work, model.force_marker[k, 0], wrench.force, moment, -1.0)


@inlined
def _push(model: Model, work: Work, k: int, force: Triple, moment: Triple, sign: float) -> None:
    """Add force and moment, global components, times `sign` at marker k to f."""
    body = model.marker_body[k]
    if body < 0:
        return
    for j in range(model.plan.size[body]):
        for a in range(3):
            push = work.J_m[k, a, j] * force[a] + work.J_m[k, 3 + a, j] * moment[a]
            work.f[body, j] += sign * push


def assemble(model: Model, t: float, y: Array) -> Equations:
    """Return the equations at time t and state y as new dense arrays; no reactions are read."""
    work = spare_work(model)
    work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    return dense(model, work)


def dense(model: Model, work: Work) -> Equations:
    """Return the last evaluation as dense arrays."""
    n_vel, n_c = model.n_vel, model.n_constraint
    M, f = np.zeros((n_vel, n_vel)), np.empty(n_vel)
    Phi_q = np.zeros((n_c, n_vel))
    rows, plan = work.rows, model.plan
    for i in range(model.n_body):
        j = model.vel_start[i]
        for a in range(plan.size[i]):
            f[j + a] = work.f[i, a]
            for b in range(a + 1):
                M[j + a, j + b] = M[j + b, j + a] = work.M[i, a, b]
        for p in range(plan.row_start[i], plan.row_start[i + 1]):
            row, column = plan.body_row[p], p - plan.row_start[i]
            for a in range(plan.size[i]):
                Phi_q[row, j + a] += work.J[i, a, column]
    return Equations(
        M,
        f,
        Phi_q,
        rows[:, :PHI].copy(),
        rows[:, PHI].copy(),
        rows[:, PHI_T].copy(),
        rows[:, GAMMA].copy(),
        work.power[:1].copy(),
        work.power[1:].copy(),
    )


def constraint_rates(model: Model, equations: Equations, y: Array) -> Array:
    """Return Phidot (n_c,) in state y; `equations` are those of the same state."""
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    return equations.Phi_q @ velocities + equations.Phi_t


def solve_dense(model: Model, equations: Equations, f: Array, gamma: Array) -> tuple[Array, Array]:
    """Solve for accelerations and multipliers with right-hand sides f (n_vel,) and gamma (n_c,).

    M a + Phi_q' lambda = f and Phi_q a = gamma, by the model's treatment, with dense
    linear algebra. The same equations hold for impulses and small motions.
    """
    if model.penalty > 0.0 and model.n_constraint > 0:
        return augmented_lagrangian(
            equations.M,
            f,
            equations.Phi_q,
            gamma,
            model.inertia_scale,
            model.penalty,
            model.multiplier_tolerance,
            model.multiplier_iterations,
        )
    if model.redundant > 0:
        return minimum_norm(
            equations.M, f, equations.Phi_q, gamma, model.inertia_scale, model.redundant
        )
    return saddle_point(equations.M, f, equations.Phi_q, gamma)


def accelerations(model: Model, equations: Equations, y: Array) -> tuple[Array, Array]:
    """Return accelerations (n_vel,) and multipliers (n_c,) in state y. Paper: Eq. (13), Eq. (14).

    The force of constraint i is -Phi_q[i] lambda_i. Multipliers of redundant
    constraints are those of least norm.
    """
    Phi_d = constraint_rates(model, equations, y)
    gamma = stabilised(equations.gamma, equations.Phi, Phi_d, model.alpha, model.beta)
    return solve_dense(model, equations, equations.f, gamma)


@inlined
def row_products(model: Model, J: Array, a: Array, out: Array) -> None:
    """Fill out (n_c,) with Phi_q a, for J (nb, n, r) and a (nb, n)."""
    plan = model.plan
    out[:] = 0.0
    for i in range(plan.size.shape[0]):
        first = plan.row_start[i]
        for p in range(plan.row_start[i + 1] - first):
            row = plan.body_row[first + p]
            for j in range(plan.size[i]):
                out[row] += J[i, j, p] * a[i, j]


@inlined
def flatten(model: Model, x: Array, out: Array, first: int) -> None:
    """Fill out from `first` on with x (nb, n), body after body: n_vel numbers."""
    for i in range(model.n_body):
        j = first + model.vel_start[i]
        for k in range(model.plan.size[i]):
            out[j + k] = x[i, k]


@inlined
def inflate(model: Model, a: Array, first: int, x: Array) -> None:
    """Fill x (nb, n) with n_vel numbers of a, from `first` on."""
    for i in range(model.n_body):
        j = first + model.vel_start[i]
        for k in range(model.plan.size[i]):
            x[i, k] = a[j + k]


@lean
def largest(a: Array) -> float:
    """Return the largest absolute value of a; nan if there is one."""
    found = 0.0
    for x in a:
        if abs(x) > found or x != x:
            found = abs(x)
    return found


@inlined
def largest_left(model: Model, work: Work, J: Array, x: Array) -> float:
    """Largest row of Phi + Phi_q x: above round-off if rows contradict each other."""
    row_products(model, J, x, work.left)
    for k in range(model.n_constraint):
        work.left[k] += work.rows[k, PHI]
    return largest(work.left)


@inlined
def evaluate_rates(model: Model, work: Work, y: Array) -> None:
    """Fill work.left with Phidot (n_c,) in state y, of the last evaluation."""
    inflate(model, y, model.n_pos, work.acceleration)
    row_products(model, work.J, work.acceleration, work.left)
    for k in range(model.n_constraint):
        work.left[k] += work.rows[k, PHI_T]


@inlined
def factorise_mass(model: Model, work: Work) -> None:
    """Factorise the mass matrix of the last evaluation with its constraints.

    If constraint rows are dependent, or nearly so, the penalty of the augmented
    Lagrangian is used, if the treatment has one: 1 / penalty on the diagonal of S, divided by the
    effective mass of the row.
    """
    work.softness[:] = 0.0
    _factorise_blocks(model, work)
    if model.penalty > 0.0 and work.factors.regular[0] < REGULAR:
        depend = rows_depend(model, model.plan.mass, work.factors, work.J, work.softness)
        work.softness[:] = 0.0
        if depend:
            soften(model, work.J, work.softness)
        _factorise_blocks(model, work)


@lean
def soften(model: Model, J: Array, softness: Array) -> None:
    """Fill softness of constraints: 1 / penalty, over the mass that each row of J (nb, n, r) moves.

    Softness (n_r,) of other rows is left alone.
    """
    plan = model.plan
    for k in range(model.n_constraint):
        softness[k] = 0.0
    for i in range(model.n_body):
        v, first = model.vel_start[i], plan.row_start[i]
        for p in range(plan.row_start[i + 1] - first):
            mobility = 0.0
            for k in range(plan.size[i]):
                mobility += J[i, k, p] ** 2 / model.inertia_scale[v + k]
            softness[plan.body_row[first + p]] += mobility
    for k in range(model.n_constraint):
        softness[k] = (softness[k] if softness[k] > 0.0 else 1.0) / model.penalty


@inlined
def _factorise_blocks(model: Model, work: Work) -> None:
    for i in range(model.n_body):
        n = model.plan.size[i]
        for a in range(n):
            for b in range(a + 1):
                work.factors.L[i, a, b] = work.M[i, a, b]
        add_inertia(model, i, 1.0, work.factors.L[i], work.softness)
    factorise(model.plan, model.plan.mass, work.factors, work.J, work.softness)


@inlined
def add_inertia(model: Model, i: int, mass: complex, L: Array, softness: Array) -> None:
    """Add what body i has of added inertia, times `mass`, to L (n, n), and fill its rows' softness.

    Softness is that of the rows of either order of the plan.
    """
    for a in range(model.plan.added_start[i], model.plan.added_start[i + 1]):
        sigma, g = mass * model.added_inertia[a], model.added_direction[a]
        for k in range(model.plan.size[i]):
            for j in range(k + 1):
                L[k, j] += sigma * g[k] * g[j]
        softness[model.n_constraint + a] = -1.0 / sigma


@inlined
def solve_mass(model: Model, work: Work) -> None:
    """Fill work.acceleration and multipliers with the solution for work.load and work.gamma.

    After `factorise_mass`. With a penalty in use the multipliers are iterated,
    lambda += (S + 1/P)^-1 (Phi_q a - gamma): Bayo's augmented Lagrangian
    (constraints/augmented_lagrangian.py), written for the multipliers. Multipliers of redundant
    rows have least norm.
    """
    a, left = work.acceleration, work.left
    plan = model.plan
    solve(plan, plan.mass, work.factors, work.load, work.gamma, a, work.multipliers)
    if model.n_constraint == 0 or not work.softness[0] > 0.0:
        return
    change, multipliers = work.change, work.change_multipliers
    work.load[:] = 0.0
    for _ in range(model.multiplier_iterations):
        row_products(model, work.J, a, left)
        for k in range(left.shape[0]):
            left[k] = work.gamma[k] - left[k]
        solve(plan, plan.mass, work.factors, work.load, left, change, multipliers)
        for k in range(left.shape[0]):
            work.multipliers[k] += multipliers[k]
        size, whole = 0.0, 0.0
        for i in range(model.n_body):
            v = model.vel_start[i]
            for k in range(model.plan.size[i]):
                a[i, k] += change[i, k]
                size += model.inertia_scale[v + k] * change[i, k] ** 2
                whole += model.inertia_scale[v + k] * a[i, k] ** 2
        if size <= model.multiplier_tolerance**2 * whole:
            break


def by_blocks(model: Model) -> bool:
    """Tell whether the bodies can be eliminated one by one, under the model's treatment.

    Not so where constraints follow from others and the treatment has no penalty.
    """
    return bool(model.redundant == 0 or model.penalty > 0.0)


@inlined
def accelerate(model: Model, work: Work, t: float, y: Array) -> None:
    """Fill work.acceleration and multipliers after an evaluation at t in state y. Paper: Eq. (13).

    For models that are solved `by_blocks`. Forces that read reactions agree with the multipliers;
    where none do, accelerations are not-a-number.
    """
    for k in range(model.n_constraint):
        work.gamma[k] = work.rows[k, GAMMA]
    if model.alpha != 0.0 or model.beta != 0.0:
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            feedback = 2.0 * model.alpha * work.left[k] + model.beta**2 * work.rows[k, PHI]
            work.gamma[k] -= feedback
    factorise_mass(model, work)
    _solve_forces(model, work)
    if reads_reactions(model):
        passed = 0
        while move_forces(model, work, t, passed):
            _solve_forces(model, work)
            passed += 1
            if passed == MOST_PASSES:
                work.acceleration[:] = np.nan
                break


@lean
def _solve_forces(model: Model, work: Work) -> None:
    for i in range(model.n_body):
        for k in range(model.plan.size[i]):
            work.load[i, k] = work.f[i, k]
    solve_mass(model, work)


@lean
def derivative_into(model: Model, work: Work, t: float, y: Array, out: Array) -> None:
    """Fill out (n,) with dy/dt: the index-1 system. Paper: Eq. (14).

    The last entry is the power of drives and dampers, so that the energy
    balance is integrated as accurately as the motion.
    """
    if reads_reactions(model):  # the result is that of the state alone, not of the last evaluation
        work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    accelerate(model, work, t, y)
    rates_into(model, y, out)
    power = work.power[0]
    for k in range(model.n_constraint):
        power += work.multipliers[k] * work.rows[k, PHI_T]
    auxiliary_rates_into(model, work, t, out)
    out[model.n_pos + model.n_vel + model.n_aux] = power
    flatten(model, work.acceleration, out, model.n_pos)


def dense_derivative_into(model: Model, work: Work, t: float, y: Array, out: Array) -> Array:
    """As `derivative_into` for any model, by dense linear algebra; return the multipliers."""
    work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    equations = dense(model, work)
    acceleration, multipliers = accelerations(model, equations, y)
    if reads_reactions(model):
        passed, work.multipliers[:] = 0, multipliers
        while move_forces(model, work, t, passed):
            equations = dense(model, work)
            acceleration, multipliers = accelerations(model, equations, y)
            passed, work.multipliers[:] = passed + 1, multipliers
            if passed == MOST_PASSES:
                acceleration = np.full(model.n_vel, np.nan)
                break
    rates_into(model, y, out)
    out[model.n_pos : model.n_pos + model.n_vel] = acceleration
    if model.n_aux > 0:
        auxiliary_rates_into(model, work, t, out)
    out[-1] = multipliers @ equations.Phi_t + equations.power[0]
    return multipliers


def derivative(model: Model, t: float, y: Array) -> Array:
    """Return dy/dt, (n,), in a new array; see `derivative_into`."""
    out = np.empty(state_size(model))
    fill = derivative_into if by_blocks(model) else dense_derivative_into
    fill(model, spare_work(model), t, y, out)
    return out


def energies(model: Model, equations: Equations, y: Array) -> Array:
    """Return kinetic, strain and potential energy, (3,) [J]. Paper: Eq. (1), Eq. (3).

    `equations` are those of state y.

    Potential energy is that of weight (zero for a mass point at the global origin) and of springs.
    """
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    out = np.zeros(3)
    out[0] = 0.5 * velocities @ (equations.M @ velocities)
    stored_energies(model, y, np.empty((3, 3)), out)
    out[2] += equations.potential[0]
    return out
