"""Derivatives of accelerations and outputs along given directions, by central differences.

Six points give an error of order h^6, and the four inner ones an estimate of it, by which the step
is chosen. Against complex steps, which are exact but need plain NumPy
(tests/peers/complex_steps.py), the differences agree to 1e-9 of the largest entry of a column.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...dynamics.analysis.recovery import DIFFERENCE, shape_sizes
from ...dynamics.evaluation.laws import with_laws
from ...dynamics.model.coordinates import displaced
from ...dynamics.model.model import Model
from ...math.arrays import Array

STEP = 2e-4  # of the size of the mechanism, rad: the first that is tried
_AT, _SIX = np.array(DIFFERENCE).T
_FOUR = np.array([0.0, 1.0, -8.0, 8.0, -1.0, 0.0]) / 12.0
_SMALLER, _TRIALS = 8.0, 6  # factor between steps, and how many are tried
_ALIKE = 1e-7  # difference of the two formulas that is small enough: the finer has 1e-10
_ROUND_OFF = 1e3 * float(np.finfo(float).eps)  # of values, below which a difference says nothing
_BATCH = 60  # directions evaluated in one call

# (model, t (k,), y (k, n)) -> values (k, r)
Evaluation = Callable[[Model, Array, Array], Array]


class Instant(NamedTuple):
    """Where the equations are linearised."""

    model: Model  # without feedback of constraint violations
    t: float  # [s]
    y: Array  # (n,)
    laws: Array  # (n_law, 3) value, rate and acceleration of the laws at t


class Derivatives(NamedTuple):
    """Derivatives along directions as columns, and an estimate of their error."""

    values: Array  # (r, n_direction)
    errors: Array  # (r, n_direction) of the formula with four points


def derivatives(
    instant: Instant, evaluation: Evaluation, directions: Array, size: float, weights: Array
) -> Derivatives:
    """Return the derivatives of an evaluation along directions.

    The step of a direction begins with STEP and becomes smaller until the two formulas agree: a
    slender body that bends by its own radius changes its inertia, whatever its length.

    Parameters
    ----------
    directions : (n_direction, 2 n_vel + n_aux + 3 n_law) displacements along the velocity
        coordinates, changes of velocities, of auxiliary states, and of value, rate and acceleration
        of each law, per unit of a parameter
    size : [m] of the mechanism, the unit of the steps
    weights : (r,) of the values when derivatives are compared; 0: left out
    """
    n, units = len(directions), np.tile(units_of(instant.model, size), 2)
    # No coordinate moves by more than STEP of its unit.
    largest = np.abs(directions[:, : units.size] * units).max(axis=1, initial=0.0)
    first = np.where(largest > 0.0, STEP / np.maximum(largest, 1e-300), 1.0)
    six, errors = np.zeros((2, n, weights.size))
    off, todo = np.full(n, np.inf), np.arange(n)
    for trial in range(_TRIALS):
        again = []
        for batch in np.array_split(todo, range(_BATCH, todo.size, _BATCH)) if todo.size else ():
            steps = first[batch, None] / _SMALLER**trial
            values = _values(instant, evaluation, steps * directions[batch])
            fine, coarse = (np.einsum("s,dsr->dr", rule, values) / steps for rule in (_SIX, _FOUR))
            error = np.linalg.norm((fine - coarse) * weights, axis=1)
            better = error < off[batch]
            six[batch[better]], off[batch[better]] = fine[better], error[better]
            errors[batch[better]] = np.abs(fine - coarse)[better]
            noise = _ROUND_OFF * np.linalg.norm(values * weights, axis=2).max(axis=1) / steps[:, 0]
            least = np.maximum(_ALIKE * np.linalg.norm(fine * weights, axis=1), noise)
            again.append(batch[error > least])
        todo = np.concatenate(again) if again else todo
    return Derivatives(six.T, errors.T)


def _values(instant: Instant, evaluation: Evaluation, moves: Array) -> Array:
    """Return values (n_direction, 6, r) at the points along some directions."""
    model, n = instant.model, 2 * instant.model.n_vel + instant.model.n_aux
    changes = (moves[:, None] * _AT[:, None]).reshape(-1, moves.shape[1])
    y = displaced(model, np.tile(instant.y, (len(changes), 1)), changes[:, :n])
    t, laws = np.full(len(y), instant.t), changes[:, n:].reshape(len(y), *instant.laws.shape)
    # Laws are the same for all states of a call.
    every = [slice(k, k + 1) for k in range(len(y))] if laws.any() else [slice(None)]
    values = [
        evaluation(with_laws(model, instant.t, instant.laws + laws[rows][0]), t[rows], y[rows])
        for rows in every
    ]
    return np.concatenate(values).reshape(len(moves), _AT.size, -1)


def units_of(model: Model, size: float) -> Array:
    """Return what makes a velocity coordinate a share of the size of the mechanism, (n_vel,)."""
    out = np.ones(model.n_vel)
    for i in range(model.n_body):
        j, m = int(model.vel_start[i]), int(model.n_mode[i])
        out[j : j + 3] = 1.0 / size
        out[j + 6 : j + 6 + m] = shape_sizes(model, i) / size
    return out
