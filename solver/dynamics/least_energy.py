"""Velocities of least kinetic energy that keep the constraints and some given values."""

import numpy as np

from ..math.arrays import Array, IntArray
from ..math.compiled import inlined, lean
from .block_vectors import flatten, largest
from .energy import momenta_into
from .evaluation import evaluate, evaluate_rates
from .mass_solution import factorise_mass, solve_mass
from .model import Model
from .workspace import Work, spare_work

# Given velocities are held by inertia: a change of the others moves them by the reciprocal of HOLD.
# What they move is taken back, and the next pass answers what this leaves open.
HOLD = 1e6
MOST_PASSES = 40
ROUND_OFF = 1e-15


def least_energy(model: Model, t: float, y: Array, given: IntArray, values: Array) -> Array:
    """Return velocities v (n_vel,) of least v' M v with Phi_q v = -Phi_t and v[given] = values.

    Linear in the number of bodies. For independent constraints; the result violates them where
    `values` contradict them.

    Parameters
    ----------
    y : (n,) a state at time t; its velocities do not matter
    given, values : (k,) numbers among the velocities, and their values
    """
    held = np.zeros(model.n_vel, dtype=np.int64)
    held[given] = 1
    start = np.zeros_like(y)
    start[: model.n_pos] = y[: model.n_pos]
    v = start[model.n_pos : model.n_pos + model.n_vel]
    v[given] = values
    _correct(model, spare_work(model), t, start, held, np.zeros_like(y), np.zeros(model.n_vel))
    return v.copy()


@lean
def _correct(
    model: Model, work: Work, t: float, y: Array, held: IntArray, moved: Array, change: Array
) -> None:
    """Replace the velocities in y (n,) that are not held (n_vel,) by those of least energy.

    `moved` (n,), zeros, and `change` (n_vel,) are memory.
    """
    evaluate(model, work, t, y)
    momenta_into(model, work, y, change)
    _load(model, work, held, -1.0, change)
    for i in range(model.n_body):
        for k in range(model.plan.size[i]):
            if held[model.vel_start[i] + k] > 0:
                work.M[i, k, k] *= HOLD
    factorise_mass(model, work)
    for _ in range(MOST_PASSES):
        evaluate_rates(model, work, y)
        for k in range(model.n_constraint):
            work.gamma[k] = -work.left[k]
        solve_mass(model, work)
        flatten(model, work.acceleration, change, 0)
        before = largest(y[model.n_pos :])
        for k in range(held.shape[0]):
            if held[k] > 0:
                moved[model.n_pos + k] = change[k]
                change[k] = 0.0
            else:
                y[model.n_pos + k] += change[k]
        if not largest(change) > ROUND_OFF * before:
            break
        momenta_into(model, work, moved, change)
        _load(model, work, held, 1.0, change)


@inlined
def _load(model: Model, work: Work, held: IntArray, sign: float, momenta: Array) -> None:
    """Fill work.load with `momenta` (n_vel,) times `sign`; nothing where velocities are held."""
    for i in range(model.n_body):
        v = model.vel_start[i]
        for k in range(model.plan.size[i]):
            work.load[i, k] = 0.0 if held[v + k] > 0 else sign * momenta[v + k]
