"""Bring a state back onto the constraints, by the least change in the metric of the mass."""

import numpy as np

from .compiled import jit
from .coordinates import moved
from .model import Model
from .package.schema import Array
from .system import assemble, constraint_rates, respond

MAX_ITERATIONS = 6
CLOSED = 1e-12  # |Phi| that needs no correction [m, rad]
TOLERABLE = 1e-9  # |Phi| that may be left where rounding allows no better [m, rad]


@jit
def projected(model: Model, t: float, y: Array) -> tuple[Array, bool]:
    """Return the state (n,) on the constraints nearest to y, and whether it was reached.

    For mechanisms with constraints.

    Positions: minimise dq' M dq / 2 subject to Phi(q + dq) = 0, by Newton's method;
    M dq + Phi_q' mu = 0, Phi_q dq = -Phi. Velocities: M dv + Phi_q' nu = 0,
    Phi_q dv = -Phidot, which by Gauss takes away kinetic energy only. Euler parameters come
    out with length one.
    """
    n_pos, n_vel = model.n_pos, model.n_vel
    nothing = np.zeros(n_vel)
    out = y.copy()
    out[:n_pos] = moved(model, y[:n_pos], nothing)
    equations = assemble(model, t, out)
    violation = np.max(np.abs(equations.Phi))
    for _ in range(MAX_ITERATIONS):
        if not violation > CLOSED:
            break
        step, _ = respond(model, equations, nothing, -equations.Phi)
        nearer = out.copy()
        nearer[:n_pos] = moved(model, out[:n_pos], step)
        equations_nearer = assemble(model, t, nearer)
        left = np.max(np.abs(equations_nearer.Phi))
        if not left < violation:
            break
        out, equations, violation = nearer, equations_nearer, left
    change, _ = respond(model, equations, nothing, -constraint_rates(model, equations, out))
    for i in range(n_vel):
        out[n_pos + i] += change[i]
    return out, bool(violation < TOLERABLE)
