"""Accelerations of a mechanism and the derivative of its state.

M a + Phi_q' lambda = f, Phi_q a = gamma is solved by elimination of the bodies, or by dense linear
algebra where a treatment of the constraints or the structure of a model requires it.
"""

from typing import NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ...math.expressions.program import NO_SEED, evaluated
from ..elements.constraints.augmented_lagrangian import augmented_lagrangian
from ..elements.constraints.baumgarte import stabilised
from ..elements.constraints.minimum_norm import minimum_norm
from ..elements.constraints.saddle_point import saddle_point
from ..elements.floating_frame import flatten, row_products
from ..model.coordinates import rates_into
from ..model.model import GAMMA, PHI, PHI_T, Model, Workspace, spare_workspace, state_size
from ..tolerances import REGULAR
from .elimination import factorise, rows_depend, solve
from .energies import stored_energies
from .evaluation import MOST_PASSES, auxiliary_rates_into, evaluate, evaluate_rates, move_forces
from .laws import is_sampled
from .reactions import reads_reactions


@inlined
def factorise_mass(model: Model, work: Workspace) -> None:
    """Factorise the mass matrix of the last evaluation with its constraints.

    If constraint rows are dependent, or nearly so, the penalty of the augmented
    Lagrangian is used, if the treatment has one: 1 / penalty on the diagonal of S, divided by the
    effective mass of the row.
    """
    work.softness[:] = 0.0
    _factorise_blocks(model, work)
    if model.penalty > 0.0 and work.factors.regular[0] < REGULAR:
        depend = rows_depend(model, model.layout.mass, work.factors, work.J, work.softness)
        work.softness[:] = 0.0
        if depend:
            soften(model, work.J, work.softness)
        _factorise_blocks(model, work)


@lean
def soften(model: Model, J: Array, softness: Array) -> None:
    """Fill softness of constraints: 1 / penalty, over the mass that each row of J (nb, n, r) moves.

    Softness (n_r,) of other rows is left alone.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    J : Jacobians by bodies (nb, n, r)
    softness : softness of the rows (n_r,), to fill for constraints
    """
    layout = model.layout
    for k in range(model.n_constraint):
        softness[k] = 0.0
    for i in range(model.n_body):
        v, first = model.vel_start[i], layout.row_start[i]
        for p in range(layout.row_start[i + 1] - first):
            mobility = 0.0
            for k in range(layout.size[i]):
                mobility += J[i, k, p] ** 2 / model.inertia_scale[v + k]
            softness[layout.body_row[first + p]] += mobility
    for k in range(model.n_constraint):
        softness[k] = (softness[k] if softness[k] > 0.0 else 1.0) / model.penalty


@inlined
def _factorise_blocks(model: Model, work: Workspace) -> None:
    for i in range(model.n_body):
        n = model.layout.size[i]
        for a in range(n):
            for b in range(a + 1):
                work.factors.L[i, a, b] = work.M[i, a, b]
        add_inertia(model, i, 1.0, work.factors.L[i], work.softness)
    factorise(model.layout, model.layout.mass, work.factors, work.J, work.softness)


@inlined
def add_inertia(model: Model, i: int, mass: complex, L: Array, softness: Array) -> None:
    """Add what body i has of added inertia, times `mass`, to L (n, n), and fill its rows' softness.

    Softness is that of the rows of either order of the layout.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    i : number of the body
    mass : factor of the mass matrix
    L : matrix of the body (n, n), lower triangle
    softness : softness of the rows (n_r,)
    """
    for a in range(model.layout.added_start[i], model.layout.added_start[i + 1]):
        sigma, g = mass * model.added_inertia[a], model.added_direction[a]
        for k in range(model.layout.size[i]):
            for j in range(k + 1):
                L[k, j] += sigma * g[k] * g[j]
        softness[model.n_constraint + a] = -1.0 / sigma


@inlined
def solve_mass(model: Model, work: Workspace) -> None:
    """Fill work.acceleration and multipliers with the solution for work.load and work.gamma.

    After `factorise_mass`. With a penalty in use the multipliers are iterated,
    lambda += (S + 1/P)^-1 (Phi_q a - gamma): Bayo's augmented Lagrangian
    (constraints/augmented_lagrangian.py), written for the multipliers. Multipliers of redundant
    rows have least norm.
    """
    a, left = work.acceleration, work.left
    layout = model.layout
    solve(layout, layout.mass, work.factors, work.load, work.gamma, a, work.multipliers)
    if model.n_constraint == 0 or not work.softness[0] > 0.0:
        return
    change, multipliers = work.change, work.change_multipliers
    work.load[:] = 0.0
    for _ in range(model.multiplier_iterations):
        row_products(model, work.J, a, left)
        for k in range(left.shape[0]):
            left[k] = work.gamma[k] - left[k]
        solve(layout, layout.mass, work.factors, work.load, left, change, multipliers)
        for k in range(left.shape[0]):
            work.multipliers[k] += multipliers[k]
        size, whole = 0.0, 0.0
        for i in range(model.n_body):
            v = model.vel_start[i]
            for k in range(model.layout.size[i]):
                a[i, k] += change[i, k]
                size += model.inertia_scale[v + k] * change[i, k] ** 2
                whole += model.inertia_scale[v + k] * a[i, k] ** 2
        if size <= model.multiplier_tolerance**2 * whole:
            break


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


def assemble(model: Model, t: float, y: Array) -> Equations:
    """Return the equations at time t and state y as new dense arrays; no reactions are read.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    work = spare_workspace(model)
    work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    return dense(model, work)


def dense(model: Model, work: Workspace) -> Equations:
    """Return the last evaluation as dense arrays."""
    n_vel, n_c = model.n_vel, model.n_constraint
    M, f, Phi_q = np.zeros((n_vel, n_vel)), np.empty(n_vel), np.zeros((n_c, n_vel))
    _dense_into(model, work, M, f, Phi_q)
    rows = work.rows
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


@lean
def _dense_into(model: Model, work: Workspace, M: Array, f: Array, Phi_q: Array) -> None:
    """Fill the mass matrix, the loads and the Jacobian, which is zero before."""
    layout = model.layout
    for i in range(model.n_body):
        j, begin = model.vel_start[i], layout.row_start[i]
        for a in range(layout.size[i]):
            f[j + a] = work.f[i, a]
            for b in range(a + 1):
                M[j + a, j + b] = M[j + b, j + a] = work.M[i, a, b]
        for p in range(begin, layout.row_start[i + 1]):
            for a in range(layout.size[i]):
                Phi_q[layout.body_row[p], j + a] += work.J[i, a, p - begin]


def masses_and_jacobians(model: Model, t: Array, y: Array) -> tuple[Array, Array]:
    """Return mass matrices (k, n_vel, n_vel) and Jacobians (k, n_c, n_vel) of states y (k, n).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : times (k,) [s]
    y : states (k, n)
    """
    k, n = len(t), model.n_vel
    M, Phi_q = np.zeros((k, n, n)), np.zeros((k, model.n_constraint, n))
    work = spare_workspace(model)
    work.multipliers[:] = 0.0
    t, y = np.ascontiguousarray(t, dtype=float), np.ascontiguousarray(y, dtype=float)
    _all_dense(model, work, t, y, M, np.empty(n), Phi_q)
    return M, Phi_q


@lean
def _all_dense(
    model: Model, work: Workspace, t: Array, y: Array, M: Array, f: Array, Phi_q: Array
) -> None:
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        _dense_into(model, work, M[k], f, Phi_q[k])


def constraint_rates(model: Model, equations: Equations, y: Array) -> Array:
    """Return Phidot (n_c,) in state y; `equations` are those of the same state.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    equations : equations of the same state
    y : state (n,), as in dynamics/model/model.py
    """
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    return equations.Phi_q @ velocities + equations.Phi_t


def solve_dense(model: Model, equations: Equations, f: Array, gamma: Array) -> tuple[Array, Array]:
    """Solve for accelerations and multipliers with right-hand sides f (n_vel,) and gamma (n_c,).

    M a + Phi_q' lambda = f and Phi_q a = gamma, by the model's treatment, with dense
    linear algebra. The same equations hold for impulses and small motions.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    equations : mass matrix and Jacobian
    f : right-hand sides of the motion (n_vel,)
    gamma : right-hand sides of the constraints (n_c,)
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

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    equations : equations of the same state
    y : state (n,), as in dynamics/model/model.py
    """
    Phi_d = constraint_rates(model, equations, y)
    gamma = stabilised(equations.gamma, equations.Phi, Phi_d, model.alpha, model.beta)
    return solve_dense(model, equations, equations.f, gamma)


def energies(model: Model, equations: Equations, y: Array) -> Array:
    """Return kinetic, strain and potential energy, (3,) [J]. Paper: Eq. (1), Eq. (3).

    `equations` are those of state y.

    Potential energy is that of weight (zero for a mass point at the global origin) and of springs.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    equations : equations of the same state
    y : state (n,), as in dynamics/model/model.py
    """
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    out = np.zeros(3)
    out[0] = 0.5 * velocities @ (equations.M @ velocities)
    stored_energies(model, y, np.empty((3, 3)), out)
    out[2] += equations.potential[0]
    return out


def by_blocks(model: Model) -> bool:
    """Return whether the bodies can be eliminated one by one, under the model's treatment.

    Not so where constraints follow from others and the treatment has no penalty.
    """
    return bool(model.redundant == 0 or model.penalty > 0.0)


@inlined
def accelerate(model: Model, work: Workspace, t: float, y: Array, factorised: bool) -> None:
    """Fill work.acceleration and multipliers after an evaluation at t in state y. Paper: Eq. (13).

    For models that are solved `by_blocks`. Forces that read reactions agree with the multipliers;
    where none do, accelerations are not-a-number.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    factorised : whether `factorise_mass` was called at these positions
    """
    for k in range(model.n_constraint):
        work.gamma[k] = work.rows[k, GAMMA]
    if model.alpha != 0.0 or model.beta != 0.0:
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            feedback = 2.0 * model.alpha * work.left[k] + model.beta**2 * work.rows[k, PHI]
            work.gamma[k] -= feedback
    if not factorised:
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
def _solve_forces(model: Model, work: Workspace) -> None:
    for i in range(model.n_body):
        for k in range(model.layout.size[i]):
            work.load[i, k] = work.f[i, k]
    solve_mass(model, work)


@lean
def derivative_into(model: Model, work: Workspace, t: float, y: Array, out: Array) -> None:
    """Fill out (n,) with dy/dt: the index-1 system. Paper: Eq. (14).

    The last entry is the power of drives and dampers, so that the energy
    balance is integrated as accurately as the motion.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    out : dy/dt (n,), to fill
    """
    derivative_at(model, work, t, y, out, False)


@lean
def derivative_at(
    model: Model, work: Workspace, t: float, y: Array, out: Array, factorised: bool
) -> None:
    """As `derivative_into`; the mass matrix may be factorised, as a projection leaves it.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    out : dy/dt (n,), to fill
    factorised : whether `factorise_mass` was called at these positions
    """
    if reads_reactions(model):  # the result is that of the state alone, not of the last evaluation
        work.multipliers[:] = 0.0
    evaluate(model, work, t, y)
    accelerate(model, work, t, y, factorised)
    rates_into(model, y, out)
    power = work.power[0]
    for k in range(model.n_constraint):
        power += work.multipliers[k] * work.rows[k, PHI_T]
    auxiliary_rates_into(model, work, t, out)
    out[model.n_pos + model.n_vel + model.n_aux] = power
    flatten(model, work.acceleration, out, model.n_pos)


@lean
def sample_into(
    model: Model, work: Workspace, t: float, y: Array, rate: Array, known: bool
) -> None:
    """Sample the periodic states of y (n,) whose instant t [s] is; fill rate (n,) with dy/dt.

    All updates read the state before: those of a controller do not see each other's.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    rate : dy/dt (n,) after sampling, to fill
    known : whether `work` holds the accelerations before sampling
    """
    q, first = model.quantities, model.n_pos + model.n_vel
    if not known:
        evaluate(model, work, t, y)
    for j in range(model.n_aux):
        if q.update[j] >= 0 and is_sampled(q.period[j], t):
            p = int(q.update[j])
            y[first + j] = evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]
    derivative_at(model, work, t, y, rate, known)


def dense_derivative_into(model: Model, work: Workspace, t: float, y: Array, out: Array) -> Array:
    """As `derivative_into` for any model, by dense linear algebra; return the multipliers.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    out : dy/dt (n,), to fill
    """
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
    """Return dy/dt, (n,), in a new array; see `derivative_into`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    out = np.empty(state_size(model))
    fill = derivative_into if by_blocks(model) else dense_derivative_into
    fill(model, spare_workspace(model), t, y, out)
    return out
