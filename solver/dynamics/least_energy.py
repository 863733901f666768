"""Velocities of least kinetic energy that keep the constraints and some given values."""

import numpy as np

from ..math.arrays import Array, IntArray
from ..math.compiled import lean
from .model import Model
from .system import evaluate, evaluate_rates, factorise_mass, flatten, solve_mass
from .workspace import Work, new_work


def least_energy(model: Model, t: float, y: Array, given: IntArray, values: Array) -> Array:
    """Return velocities v (n_vel,) of least v' M v with Phi_q v = -Phi_t and v[given] = values.

    Linear in the number of bodies for few given velocities. For independent constraints; the
    result violates them where `values` contradict them.

    Parameters
    ----------
    y : (n,) a state at time t; its velocities do not matter
    given, values : (k,) numbers among the velocities, and their values
    """
    still = y.copy()
    still[model.n_pos : model.n_pos + model.n_vel] = 0.0
    v, X = np.zeros(model.n_vel), np.zeros((given.size, model.n_vel))
    _responses(model, new_work(model), t, still, given, v, X)
    if given.size:
        v += np.linalg.lstsq(X[:, given].T, values - v[given], rcond=1e-12)[0] @ X
        v[given] = values
    return v


@lean
def _responses(
    model: Model, work: Work, t: float, y: Array, given: IntArray, v: Array, X: Array
) -> None:
    """Fill v (n_vel,), free of `given`, and what a unit impulse along each given one adds."""
    evaluate(model, work, t, y)
    evaluate_rates(model, work, y)
    factorise_mass(model, work)
    for k in range(model.n_constraint):
        work.gamma[k] = -work.left[k]
    work.load[:] = 0.0
    solve_mass(model, work)
    flatten(model, work.acceleration, v, 0)
    work.gamma[:] = 0.0
    for s in range(given.shape[0]):
        work.load[:] = 0.0
        for i in range(model.n_body):
            k = given[s] - model.vel_start[i]
            if k >= 0 and k < model.plan.size[i]:
                work.load[i, k] = 1.0
        solve_mass(model, work)
        flatten(model, work.acceleration, X[s], 0)
