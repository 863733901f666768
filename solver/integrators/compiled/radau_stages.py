"""Stages of a Radau IIA step: coefficients, memory, prediction, correction, dependent rows.

Redundant constraints agree with each other in closed positions only. At the stages of a step they
contradict each other by what these positions miss, and a Newton iteration that insists on all of
them finds no answer: the part of the multipliers without effect grows, from iteration to
iteration and from step to step. Where the matrices have softened rows (pencil.py), the stages
therefore solve

    Phi_q vdot - e (lambda - lambda_p) = gamma

with the softness e of the matrices and the predicted multipliers lambda_p. The motion is that of
the rows without e: where rows are independent, lambda_p is right up to the error of a prediction.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...dynamics.evaluation.accelerations import derivative_into, sample_into
from ...dynamics.evaluation.elimination import solve
from ...dynamics.model.coordinates import rates_into
from ...dynamics.model.model import Model, Workspace, new_workspace
from ...math.arrays import Array, IntArray, zeros_of
from ...math.compiled import inlined, lean, structure
from .cutoff import Cutoff, new_cutoff
from .pencil import Frozen, Pencil, factorise_feedback, factorise_pencil, new_frozen, new_pencil
from .residual import inertia_residual, start_forces
from .step_control import (
    BEGUN,
    ERROR_LAST,
    GROWTH,
    LIMIT,
    N_CLOCK,
    N_COUNT,
    NEXT,
    OTHER,
    RATE,
    ROUGH,
    SINCE,
    STEPS,
    TAKEN,
    TIME,
    Options,
    norm,
    set_weights,
)

SOFT = 0.1  # work of springs and dampers over kinetic energy, of motions that are not stiff
FRESH = 2  # steps after a restart that continue no polynomial
ROOT = np.sqrt(6.0)
C = np.array([(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0])  # stages [h]
# Powers of a collocation polynomial that vanishes at 0, from its values at C: c_k of x^(k+1).
POWERS = np.linalg.inv(np.column_stack([C, C**2, C**3]))
# Stage equations z = h A f: A integrates the polynomial through f at C.
A = np.column_stack([C, C**2 / 2.0, C**3 / 3.0]) @ np.linalg.inv(np.vander(C, 3, increasing=True))
A_INVERSE = np.linalg.inv(A)


def _real_form() -> tuple[float, complex, np.ndarray, np.ndarray]:
    """Return mu, nu, T, T^-1 with T^-1 A^-1 T = [mu; Re nu, -Im nu; Im nu, Re nu]."""
    values, vectors = np.linalg.eig(np.linalg.inv(A))
    real = int(np.argmin(np.abs(values.imag)))
    pair = int(np.argmin(values.imag))
    T = np.column_stack([vectors[:, real].real, vectors[:, pair].real, vectors[:, pair].imag])
    # A^-1 (u + i v) = nu' (u + i v): w_1 + i w_2 is multiplied by the conjugate of nu'
    return float(values[real].real), complex(values[pair].conjugate()), T, np.linalg.inv(T)


MU, NU, T, T_INVERSE = _real_form()
# Embedded formula of order 3, times 1 / h: f_0 + ERROR z / h, then divided by mu / h - J.
ERROR = np.array([-13.0 - 7.0 * ROOT, -13.0 + 7.0 * ROOT, -1.0]) / 3.0


@structure
class RadauWorkspace(NamedTuple):
    """Memory of a run, which a call takes up where the last one left it."""

    work: Workspace
    frozen: Frozen
    real: Pencil
    pair: Pencil
    y: Array  # (n,) state
    f: Annotated[Array, "n"]  # its rate
    # of accelerations at the last restart, of positions G times it; 0: forgotten
    jump: Annotated[Array, "n"]
    y_old: Array  # (n,) state at the beginning of the last step
    Q: Annotated[Array, "3, n"]  # polynomial of the last step
    Z: Annotated[Array, "3, n"]  # changes at the stages
    multipliers: Annotated[Array, "3, n_r"]  # at the stages, by row of layout.newton
    multipliers_old: Annotated[Array, "3, n_r"]  # at those of the last step
    predicted: Annotated[Array, "3, n_r"]  # at the stages, before the iteration
    power: Annotated[Array, "3"]  # at the stages [W]
    driven: Annotated[Array, "3, n_c"]  # rates of the constraints by time at the stages
    load: Annotated[Array, "3, nb, widest"]  # residuals of the stages: forces,
    gamma: Annotated[Array, "3, n_r"]  # constraints and laws of elements
    r: Annotated[Array, "3, n"]  # and kinematics
    stage: Annotated[Array, "n"]
    rate: Annotated[Array, "n"]  # at a stage
    weight: Annotated[Array, "n"]
    cutoff: Cutoff
    least: Array  # (n_e,) stiffness that elements have had [N/m, N m/rad]
    damped: Annotated[Array, "1"]  # energy lost above the cutoff [J]
    clock: Annotated[Array, "clock"]
    counts: Annotated[IntArray, "count"]
    blamed: Annotated[IntArray, "n"]  # refusals that each component was the reason of
    # of what is no part of a step: joints closed at output times
    apart: Annotated[IntArray, "count"]


def new_radau_workspace(model: Model, t: float, y: Array, first_step: float) -> RadauWorkspace:
    """Return memory for a run from state y (n,) at t [s], which `restart_radau` begins.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    first_step : size of the first step [s]
    """
    n, nb, widest = y.shape[0], model.n_body, model.layout.widest
    n_r = model.layout.newton.place.shape[0]
    frozen, least = new_frozen(model), np.full(model.layout.element_row.shape[0], np.inf)
    sizes = {"n": n, "nb": nb, "widest": widest, "n_r": n_r, "n_c": model.n_constraint}
    workspace = zeros_of(
        RadauWorkspace,
        sizes | {"clock": N_CLOCK, "count": N_COUNT},
        work=new_workspace(model),
        frozen=frozen,
        real=new_pencil(model, 1.0),
        pair=new_pencil(model, 1.0 + 0.0j),
        y=y.copy(),
        y_old=y.copy(),
        cutoff=new_cutoff(model, frozen, least),
        least=least,
    )
    workspace.clock[TIME], workspace.clock[NEXT], workspace.clock[ERROR_LAST] = t, first_step, 1.0
    workspace.clock[LIMIT], workspace.clock[ROUGH], workspace.clock[GROWTH] = 1e300, 1e300, 1.0
    workspace.clock[SINCE], workspace.clock[OTHER] = t, np.inf
    return workspace


@lean
def restart_radau(model: Model, workspace: RadauWorkspace, t: float, samples: bool) -> None:
    """Evaluate the state at t [s], behind a jump of forces, for the next step.

    `predict` continues the polynomials of the last step, with the jumps of accelerations and
    multipliers added. They are forgotten if TAKEN is 0, or if the jump is of a stiff motion, which
    dies out within a step.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of the run
    t : time [s]
    samples : whether t is an instant at which the states are sampled first
    """
    jump, stage, clock = workspace.jump, workspace.stage, workspace.clock
    first, work, L = model.n_pos, workspace.work, workspace.multipliers_old
    for i in range(stage.shape[0]):
        jump[i] = -workspace.f[i]
    if samples:
        sample_into(model, work, t, workspace.y, workspace.f, False)
    else:
        derivative_into(model, work, t, workspace.y, workspace.f)
    for i in range(stage.shape[0]):
        jump[i] += workspace.f[i]
        stage[i] = workspace.y[i] if i < first else jump[i]
    rates_into(model, stage, jump)
    if clock[TAKEN] == 0.0 or _stiff(model, workspace):
        clock[TAKEN], clock[BEGUN], jump[:], L[:] = 0.0, workspace.counts[STEPS], 0.0, 0.0
    now = workspace.predicted[0]
    for i in range(model.n_constraint):
        now[i] = work.multipliers[i]
    start_forces(model, work, now)
    for i in range(now.shape[0]):
        more = now[i] - L[2, i]
        for k in range(3):
            L[k, i] += more


@inlined
def _stiff(model: Model, workspace: RadauWorkspace) -> bool:
    """Return whether the jump of accelerations begins a stiff motion.

    It does if springs and dampers, in a step like the last one, take more than SOFT of the kinetic
    energy of that motion. Mechanisms with modes always count as stiff, because most modes are.
    """
    frozen, real, jump, h = workspace.frozen, workspace.real, workspace.jump, workspace.clock[TAKEN]
    none, rest = workspace.load[0], workspace.gamma[0]
    none[:, :] = 0.0
    rest[:] = 0.0
    real.gamma[:] = 0.0
    inertia_residual(model, frozen, jump, rest, none, real.load, real.gamma)
    moved, held, modes = 0.0, 0.0, 0
    for i in range(model.n_body):
        modes += model.n_mode[i]
        for k in range(model.layout.size[i]):
            moved -= real.load[i, k] * jump[model.n_pos + model.vel_start[i] + k]
    first = model.n_constraint + model.layout.added_start[model.n_body]
    for k in range(frozen.stiffness.shape[0]):
        answer = abs(frozen.damping[k]) + 0.5 * h * abs(frozen.stiffness[k])
        held += h * answer * real.gamma[first + k] ** 2
    real.gamma[:] = 0.0
    return modes > 0 or held > SOFT * moved


@inlined
def predict(model: Model, workspace: RadauWorkspace, h: float) -> None:
    """Begin a step of h with the polynomials of the last one, continued.

    Behind a restart, the jump of accelerations is added. After a start there are no polynomials.
    Where a restart has forgotten them, those of the first step belong to a transient and are not
    continued either. Then positions follow their rates, velocities and multipliers stay, and
    Newton's iteration has no known rate of convergence.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of the run
    h : step size [s]
    """
    Z, Q, clock = workspace.Z, workspace.Q, workspace.clock
    L, L_old = workspace.multipliers, workspace.multipliers_old
    fresh = workspace.counts[STEPS] - clock[BEGUN] < (FRESH if clock[BEGUN] > 0.0 else 1)
    if fresh:
        clock[RATE] = 1.0
    for k in range(3):
        x, w0, w1, w2 = 1.0, 0.0, 0.0, 1.0
        if not fresh:
            x = 1.0 + C[k] * h / clock[TAKEN]
            w0 = (x - C[1]) * (x - C[2]) / ((C[0] - C[1]) * (C[0] - C[2]))
            w1 = (x - C[0]) * (x - C[2]) / ((C[1] - C[0]) * (C[1] - C[2]))
            w2 = (x - C[0]) * (x - C[1]) / ((C[2] - C[0]) * (C[2] - C[1]))
        for i in range(workspace.y.shape[0]):
            whole = Q[0, i] + Q[1, i] + Q[2, i]
            Z[k, i] = x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i])) - whole
        for i in range(model.n_pos + model.n_vel):
            Z[k, i] += C[k] * h * workspace.jump[i] * (0.5 * C[k] * h if i < model.n_pos else 1.0)
        for i in range(model.n_pos if fresh else 0):
            Z[k, i] = C[k] * h * workspace.f[i]
        for i in range(L.shape[1]):
            L[k, i] = w0 * L_old[0, i] + w1 * L_old[1, i] + w2 * L_old[2, i]
            workspace.predicted[k, i] = L[k, i]


@inlined
def place(workspace: RadauWorkspace, k: int, h: float) -> None:
    """Fill workspace.stage and its rate for stage k: K = A^-1 Z / h.

    Parameters
    ----------
    workspace : memory of the run
    k : number of the stage, 0 to 2
    h : step size [s]
    """
    Z, stage, rate = workspace.Z, workspace.stage, workspace.rate
    a0, a1, a2 = A_INVERSE[k, 0] / h, A_INVERSE[k, 1] / h, A_INVERSE[k, 2] / h
    for i in range(stage.shape[0]):
        stage[i] = workspace.y[i] + Z[k, i]
        rate[i] = a0 * Z[0, i] + a1 * Z[1, i] + a2 * Z[2, i]


@inlined
def transform_residuals(model: Model, workspace: RadauWorkspace) -> None:
    """Transform the stage residuals by T^-1 into right-hand sides of the real and complex
    systems."""
    real, pair = workspace.real, workspace.pair
    load, gamma, r = workspace.load, workspace.gamma, workspace.r
    for i in range(load.shape[1]):
        for k in range(load.shape[2]):
            one, two = _decouple(load[0, i, k], load[1, i, k], load[2, i, k])
            real.load[i, k], pair.load[i, k] = one, two
    for i in range(gamma.shape[1]):
        real.gamma[i], pair.gamma[i] = _decouple(gamma[0, i], gamma[1, i], gamma[2, i])
    for i in range(model.n_pos):
        real.r[i], pair.r[i] = _decouple(r[0, i], r[1, i], r[2, i])
    first = model.n_pos + model.n_vel
    for i in range(first, first + model.n_aux):
        real.r[i], pair.r[i] = _decouple(r[0, i], r[1, i], r[2, i])


@inlined
def _decouple(a: float, b: float, c: float) -> tuple[float, complex]:
    """T^-1 (a, b, c): the real part and the pair of the stages' equations."""
    TI = T_INVERSE
    one = TI[0, 0] * a + TI[0, 1] * b + TI[0, 2] * c
    two = TI[1, 0] * a + TI[1, 1] * b + TI[1, 2] * c
    three = TI[2, 0] * a + TI[2, 1] * b + TI[2, 2] * c
    return one, complex(two, three)


@inlined
def correct(
    model: Model, options: Options, workspace: RadauWorkspace, h: float
) -> tuple[float, float]:
    """Add the pencils' answers to stages, multipliers and the power of drives.

    Returns their size in tolerances, and the change of the work of drives in a step of h [J].

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    options : tolerances and options of the run (step_control.py)
    workspace : memory of the run
    h : step size [s]
    """
    real, pair, Z, L = workspace.real, workspace.pair, workspace.Z, workspace.multipliers
    stage = workspace.stage
    n = stage.shape[0] - 1
    stage[n] = 0.0
    size, work = 0.0, 0.0
    for k in range(3):
        t0, t1, t2 = T[k, 0], T[k, 1], T[k, 2]
        for i in range(n):
            c = pair.delta[i]
            change = t0 * real.delta[i] + t1 * c.real + t2 * c.imag
            stage[i] = change
            Z[k, i] += change
        for i in range(L.shape[1]):
            c = pair.mu[i]
            change = t0 * real.mu[i] + t1 * c.real + t2 * c.imag
            L[k, i] += change
            if i < model.n_constraint:
                power = change * workspace.driven[k, i]
                workspace.power[k] += power
                work += h * A[2, k] * power
        largest = norm(options, stage, workspace.weight)
        if largest > size or largest != largest:
            size = largest
    return size, abs(work)


@inlined
def complete(options: Options, workspace: RadauWorkspace, h: float) -> None:
    """Fill the stage with the end of the step; weights, and the work of drives and dampers.

    Parameters
    ----------
    options : tolerances and options of the run (step_control.py)
    workspace : memory of the run
    h : step size [s]
    """
    y, Z, stage, power = workspace.y, workspace.Z, workspace.stage, workspace.power
    n = y.shape[0]
    for k in range(3):
        Z[k, n - 1] = h * (A[k, 0] * power[0] + A[k, 1] * power[1] + A[k, 2] * power[2])
    for i in range(n):
        stage[i] = y[i] + Z[2, i]
    set_weights(options, y, stage, workspace.weight)


@inlined
def embedded_error(workspace: RadauWorkspace, h: float) -> None:
    """Fill workspace.rate with ERROR Z / h: with f, the error of the embedded formula, order 3."""
    Z, rate = workspace.Z, workspace.rate
    e0, e1, e2 = ERROR[0] / h, ERROR[1] / h, ERROR[2] / h
    for i in range(rate.shape[0]):
        rate[i] = e0 * Z[0, i] + e1 * Z[1, i] + e2 * Z[2, i]


@inlined
def error_residual(model: Model, workspace: RadauWorkspace) -> None:
    """Hand f + ERROR Z / h to the real pencil, velocities as forces."""
    real, frozen, rate = workspace.real, workspace.frozen, workspace.rate
    for i in range(rate.shape[0]):
        real.r[i] = workspace.f[i] + rate[i]
        rate[i] = -real.r[i]  # what is left of zero, once it is taken away
    workspace.load[0, :, :] = 0.0
    workspace.gamma[0, :] = 0.0
    real.gamma[:] = 0.0
    rest, none = workspace.gamma[0], workspace.load[0]
    inertia_residual(model, frozen, rate, rest, none, real.load, real.gamma)


@inlined
def accept(workspace: RadauWorkspace, h: float) -> None:
    """Make workspace.stage the state; keep the step's rate, polynomial and multipliers."""
    Z, Q, y = workspace.Z, workspace.Q, workspace.y
    a0, a1, a2 = A_INVERSE[2, 0] / h, A_INVERSE[2, 1] / h, A_INVERSE[2, 2] / h
    for i in range(y.shape[0]):
        workspace.y_old[i], y[i] = y[i], workspace.stage[i]
        z0, z1, z2 = Z[0, i], Z[1, i], Z[2, i]
        workspace.f[i] = a0 * z0 + a1 * z1 + a2 * z2
        workspace.jump[i] = 0.0
        for k in range(3):
            Q[k, i] = POWERS[k, 0] * z0 + POWERS[k, 1] * z1 + POWERS[k, 2] * z2
    for k in range(3):
        for i in range(workspace.multipliers.shape[1]):
            workspace.multipliers_old[k, i] = workspace.multipliers[k, i]


@inlined
def interpolate(workspace: RadauWorkspace, x: float, out: Array) -> None:
    """Fill out (n,) with the polynomial of the last step at its part x, 0 to 1.

    Parameters
    ----------
    workspace : memory of the run
    x : part of the step, 0 to 1
    out : state there (n,), to fill
    """
    Q = workspace.Q
    for i in range(out.shape[0]):
        out[i] = workspace.y_old[i] + x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i]))


# Of the softness, relative to the mass that a row moves. More: Newton's iteration needs shorter
# steps. Less: multipliers of rows that are nearly dependent are those of the last step.
PENALTY = 1e5
PASSES = 4


@inlined
def softened(frozen: Frozen) -> bool:
    """Return whether the matrices treat rows as dependent."""
    return bool(frozen.softness.shape[0] > 0 and frozen.softness[0] > 0.0)


@inlined
def factorise_stages(model: Model, workspace: RadauWorkspace, h: float) -> int:
    """Factorise the matrices of a step of h, with the same softness in both; return how many.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of the run
    h : step size [s]
    """
    frozen, real, pair = workspace.frozen, workspace.real, workspace.pair
    factorise_pencil(model, frozen, real, (MU / h) ** 2, MU / h, 1.0)
    hard = not softened(frozen)
    factorise_pencil(model, frozen, pair, (NU / h) * (NU / h), NU / h, 1.0)
    again = hard and softened(frozen)
    if again:
        factorise_pencil(model, frozen, real, (MU / h) ** 2, MU / h, 1.0)
    factorise_feedback(model, frozen, real, MU / h)
    factorise_feedback(model, frozen, pair, NU / h)
    return 3 if again else 2


@inlined
def yield_rows(workspace: RadauWorkspace) -> None:
    """Add e (lambda - lambda_p) to the stage residuals of the constraints."""
    soft, gamma = workspace.frozen.softness, workspace.gamma
    for k in range(3):
        for i in range(soft.shape[0]):
            gamma[k, i] += soft[i] * (workspace.multipliers[k, i] - workspace.predicted[k, i])


@inlined
def reduce_multipliers(model: Model, workspace: RadauWorkspace) -> None:
    """Take out of the multipliers of the stages what has no effect.

    With the softened rows, least multipliers F lambda answer the load Phi_q' lambda, where F is
    s / (s + e) for a combination of rows with the stiffness s. What is taken out is
    (1 - F)^PASSES lambda: all of dependent rows, next to nothing of weak ones.
    """
    real, J, L = workspace.real, workspace.frozen.J, workspace.multipliers
    idle = workspace.predicted  # memory that the next prediction fills
    layout, row_start, body_row = model.layout, model.layout.row_start, model.layout.body_row
    n_c = model.n_constraint
    for k in range(3):
        for i in range(n_c):
            idle[k, i] = L[k, i]
        for _ in range(PASSES):
            real.gamma[:] = 0.0
            real.load[:] = 0.0
            for i in range(layout.size.shape[0]):
                first = row_start[i]
                for p in range(row_start[i + 1] - first):
                    row = body_row[first + p]
                    if row < n_c:
                        for a in range(layout.size[i]):
                            real.load[i, a] += J[i, a, p] * idle[k, row]
            solve(layout, layout.newton, real.factors, real.load, real.gamma, real.x, real.mu)
            for i in range(n_c):
                idle[k, i] -= real.mu[i]
        for i in range(n_c):
            L[k, i] -= idle[k, i]
