"""Stages of one Radau IIA step: their prediction, state, rates, and correction."""

from ...dynamics.model.model import Model
from ...math.arrays import Array
from ...math.compiled import inlined
from .error_norm import norm, set_weights
from .radau_workspace import A_INVERSE, ERROR, POWERS, T_INVERSE, A, C, RadauWorkspace, T
from .residual import inertia_residual
from .step_control import Options


@inlined
def predict(workspace: RadauWorkspace, h: float, last: float) -> None:
    """Begin a step of h with the polynomials of the last one, continued; constant without one."""
    Z, Q = workspace.Z, workspace.Q
    L, L_old = workspace.multipliers, workspace.multipliers_old
    for k in range(3):
        x, w0, w1, w2 = 1.0, 1.0, 0.0, 0.0
        if last > 0.0:
            x = 1.0 + C[k] * h / last
            w0 = (x - C[1]) * (x - C[2]) / ((C[0] - C[1]) * (C[0] - C[2]))
            w1 = (x - C[0]) * (x - C[2]) / ((C[1] - C[0]) * (C[1] - C[2]))
            w2 = (x - C[0]) * (x - C[1]) / ((C[2] - C[0]) * (C[2] - C[1]))
        for i in range(workspace.y.shape[0]):
            whole = Q[0, i] + Q[1, i] + Q[2, i]
            Z[k, i] = x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i])) - whole
        for i in range(L.shape[1]):
            L[k, i] = w0 * L_old[0, i] + w1 * L_old[1, i] + w2 * L_old[2, i]
            workspace.predicted[k, i] = L[k, i]


@inlined
def place(workspace: RadauWorkspace, k: int, h: float) -> None:
    """Fill workspace.stage and its rate for stage k: K = A^-1 Z / h."""
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
def correct(options: Options, workspace: RadauWorkspace) -> float:
    """Add the pencils' answers to stages and multipliers; return their size in tolerances."""
    real, pair, Z, L = workspace.real, workspace.pair, workspace.Z, workspace.multipliers
    stage = workspace.stage
    n = stage.shape[0] - 1
    stage[n] = 0.0
    size = 0.0
    for k in range(3):
        t0, t1, t2 = T[k, 0], T[k, 1], T[k, 2]
        for i in range(n):
            c = pair.delta[i]
            change = t0 * real.delta[i] + t1 * c.real + t2 * c.imag
            stage[i] = change
            Z[k, i] += change
        for i in range(L.shape[1]):
            c = pair.mu[i]
            L[k, i] += t0 * real.mu[i] + t1 * c.real + t2 * c.imag
        largest = norm(options, stage, workspace.weight)
        if largest > size or largest != largest:
            size = largest
    return size


@inlined
def complete(options: Options, workspace: RadauWorkspace, h: float) -> None:
    """Fill the stage with the end of the step; weights, and the work of drives and dampers."""
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
    inertia_residual(
        model,
        frozen.M,
        frozen.J,
        rate,
        workspace.gamma[0],
        workspace.load[0],
        real.load,
        real.gamma,
    )


@inlined
def accept(workspace: RadauWorkspace, h: float) -> None:
    """Make workspace.stage the state; keep the step's rate, polynomial and multipliers."""
    Z, Q, y = workspace.Z, workspace.Q, workspace.y
    a0, a1, a2 = A_INVERSE[2, 0] / h, A_INVERSE[2, 1] / h, A_INVERSE[2, 2] / h
    for i in range(y.shape[0]):
        workspace.y_old[i], y[i] = y[i], workspace.stage[i]
        z0, z1, z2 = Z[0, i], Z[1, i], Z[2, i]
        workspace.f[i] = a0 * z0 + a1 * z1 + a2 * z2
        for k in range(3):
            Q[k, i] = POWERS[k, 0] * z0 + POWERS[k, 1] * z1 + POWERS[k, 2] * z2
    for k in range(3):
        for i in range(workspace.multipliers.shape[1]):
            workspace.multipliers_old[k, i] = workspace.multipliers[k, i]


@inlined
def interpolate(workspace: RadauWorkspace, x: float, out: Array) -> None:
    """Fill out (n,) with the polynomial of the last step at its part x, 0 to 1."""
    Q = workspace.Q
    for i in range(out.shape[0]):
        out[i] = workspace.y_old[i] + x * (Q[0, i] + x * (Q[1, i] + x * Q[2, i]))
