"""Derivatives of accelerations and outputs along given directions, by central differences.

Six points give an error of order h^6, and the four inner ones an estimate of it, by which the step
is chosen. Against complex steps, which are exact but need plain NumPy
(tests/peers/complex_steps.py), the differences agree to 1e-9 of the largest entry of a column.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...dynamics.analysis.recovery import DIFFERENCE, shape_sizes
from ...dynamics.evaluation.laws import with_laws
from ...dynamics.model.coordinates import moved
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


class Direction(NamedTuple):
    """Change of a state and of the laws of time, per unit of a parameter."""

    x: Array  # (n_vel,) displacement along the velocity coordinates
    u: Array  # (n_vel,) change of velocities
    laws: Array  # (n_law, 3) change of value, rate and acceleration of each law
    states: Array  # (n_aux,) change of auxiliary states


class Instant(NamedTuple):
    """Where the equations are linearised."""

    model: Model  # without feedback of constraint violations
    t: float  # [s]
    y: Array  # (n,)
    laws: Array  # (n_law, 3) value, rate and acceleration of the laws at t

    def direction(
        self,
        x: Array | None = None,
        u: Array | None = None,
        laws: Array | None = None,
        states: Array | None = None,
    ) -> Direction:
        """Return a direction; what is not given is zero."""
        none = np.zeros(self.model.n_vel)
        return Direction(
            none if x is None else x,
            none if u is None else u,
            np.zeros_like(self.laws) if laws is None else laws,
            np.zeros(self.model.n_aux) if states is None else states,
        )


class Derivatives(NamedTuple):
    """Derivatives along directions as columns, and an estimate of their error."""

    values: Array  # (r, n_direction)
    errors: Array  # (r, n_direction) of the formula with four points


def derivatives(
    instant: Instant,
    evaluation: Evaluation,
    directions: Sequence[Direction],
    size: float,
    weights: Array,
) -> Derivatives:
    """Return the derivatives of an evaluation along directions.

    The step of a direction begins with STEP and becomes smaller until the two formulas agree: a
    slender body that bends by its own radius changes its inertia, whatever its length.

    Parameters
    ----------
    size : [m] of the mechanism, the unit of the steps
    weights : (r,) of the values when derivatives are compared; 0: left out
    """
    n, units = len(directions), units_of(instant.model, size)
    six, errors = np.zeros((n, weights.size)), np.zeros((n, weights.size))
    off, share = np.full(n, np.inf), 1.0
    todo = list(range(n))
    for _ in range(_TRIALS):
        again = []
        for begin in range(0, len(todo), _BATCH):
            batch = todo[begin : begin + _BATCH]
            steps = np.array([share * _step(directions[k], units) for k in batch])
            values = _values(instant, evaluation, [directions[k] for k in batch], steps)
            fine = np.einsum("s,dsr->dr", _SIX, values) / steps[:, None]
            coarse = np.einsum("s,dsr->dr", _FOUR, values) / steps[:, None]
            noise = _ROUND_OFF * np.linalg.norm(values * weights, axis=2).max(axis=1) / steps
            for k, one, two, least in zip(batch, fine, coarse, noise, strict=True):
                error = float(np.linalg.norm((one - two) * weights))
                if error < off[k]:
                    six[k], errors[k], off[k] = one, np.abs(one - two), error
                if error > max(_ALIKE * float(np.linalg.norm(one * weights)), least):
                    again.append(k)
        todo, share = again, share / _SMALLER
        if not todo:
            break
    return Derivatives(six.T, errors.T)


def _values(
    instant: Instant, evaluation: Evaluation, directions: list[Direction], steps: Array
) -> Array:
    """Return values (n_direction, 6, r) at the points along some directions."""
    pairs = list(zip(directions, steps.tolist(), strict=True))
    if any(d.laws.any() for d in directions):
        return np.array([_one(instant, evaluation, d, h) for d, h in pairs])
    y = np.array([_state(instant, d, s * h) for d, h in pairs for s in _AT])
    model = with_laws(instant.model, instant.t, instant.laws)
    return evaluation(model, _times(instant, y), y).reshape(len(directions), _AT.size, -1)


def _one(instant: Instant, evaluation: Evaluation, d: Direction, h: float) -> Array:
    """Return values (6, r) along one direction that changes laws."""
    rows = []
    for s in _AT:
        y = _state(instant, d, s * h)[None]
        model = with_laws(instant.model, instant.t, instant.laws + s * h * d.laws)
        rows.append(evaluation(model, _times(instant, y), y)[0])
    return np.array(rows)


def _times(instant: Instant, y: Array) -> Array:
    return np.full(len(y), instant.t)


def _state(instant: Instant, d: Direction, s: float) -> Array:
    model, y = instant.model, instant.y.copy()
    y[: model.n_pos] = moved(model, instant.y[: model.n_pos], s * d.x)
    first = model.n_pos + model.n_vel
    y[model.n_pos : first] += s * d.u
    y[first : first + model.n_aux] += s * d.states
    return y


def _step(d: Direction, units: Array) -> float:
    """Return the step along a direction: no coordinate moves by more than STEP of its unit."""
    largest = max(
        float(np.max(np.abs(d.x) * units, initial=0.0)),
        float(np.max(np.abs(d.u) * units, initial=0.0)),
    )
    return STEP / largest if largest > 0.0 else 1.0


def units_of(model: Model, size: float) -> Array:
    """Return what makes a velocity coordinate a share of the size of the mechanism, (n_vel,)."""
    out = np.ones(model.n_vel)
    for i in range(model.n_body):
        j, m = int(model.vel_start[i]), int(model.n_mode[i])
        out[j : j + 3] = 1.0 / size
        out[j + 6 : j + 6 + m] = shape_sizes(model, i) / size
    return out
