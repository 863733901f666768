"""Derivatives of accelerations and outputs along given directions, by central differences.

Six points give an error of order h^6, and the four inner ones an estimate of it. With steps of
2e-4 of the size of the mechanism the truncation and the round-off of double precision are both
about 1e-12 of the derivative. Accelerations are quadratic in the velocities and polynomials of
the modal coordinates: there the differences are exact but for round-off.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..dynamics.coordinates import moved
from ..dynamics.instant import with_laws
from ..dynamics.model import Model
from ..dynamics.scales import shape_sizes
from ..math.arrays import Array

STEP = 2e-4  # of the size of the mechanism, rad
_AT = np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])
_SIX = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / 60.0
_FOUR = np.array([0.0, 1.0, -8.0, 8.0, -1.0, 0.0]) / 12.0
_BATCH = 60  # directions evaluated in one call

# (model, t (k,), y (k, n)) -> values (k, r)
Evaluation = Callable[[Model, Array, Array], Array]


class Direction(NamedTuple):
    """Change of a state and of the laws of time, per unit of a parameter."""

    x: Array  # (n_vel,) displacement along the velocity coordinates
    u: Array  # (n_vel,) change of velocities
    laws: Array  # (n_law, 3) change of value, rate and acceleration of each law


class Instant(NamedTuple):
    """Where the equations are linearised."""

    model: Model  # without feedback of constraint violations
    t: float  # [s]
    y: Array  # (n,)
    laws: Array  # (n_law, 3) value, rate and acceleration of the laws at t

    def direction(
        self, x: Array | None = None, u: Array | None = None, laws: Array | None = None
    ) -> Direction:
        """Return a direction; what is not given is zero."""
        none = np.zeros(self.model.n_vel)
        return Direction(
            none if x is None else x,
            none if u is None else u,
            np.zeros_like(self.laws) if laws is None else laws,
        )


class Derivatives(NamedTuple):
    """Derivatives along directions as columns, and an estimate of their error."""

    values: Array  # (r, n_direction)
    errors: Array  # (r, n_direction) of the formula with four points


def derivatives(
    instant: Instant, evaluation: Evaluation, directions: Sequence[Direction], size: float
) -> Derivatives:
    """Return the derivatives of an evaluation along directions.

    Parameters
    ----------
    size : [m] of the mechanism, the unit of the steps
    """
    n = len(directions)
    if n == 0:
        rows = evaluation(instant.model, np.full(1, instant.t), instant.y[None]).shape[1]
        return Derivatives(np.zeros((rows, 0)), np.zeros((rows, 0)))
    units = units_of(instant.model, size)
    found: list[tuple[Array, Array]] = []
    for begin in range(0, n, _BATCH):
        batch = directions[begin : begin + _BATCH]
        steps = [_step(d, units) for d in batch]
        pairs = list(zip(batch, steps, strict=True))
        if any(d.laws.any() for d in batch):
            values = np.array([_one(instant, evaluation, d, h) for d, h in pairs])
        else:
            y = np.array([_state(instant, d, s * h) for d, h in pairs for s in _AT])
            model = with_laws(instant.model, instant.t, instant.laws)
            rows = evaluation(model, _times(instant, y), y)
            values = rows.reshape(len(batch), _AT.size, -1)
        scale = np.array(steps)[:, None]
        six = np.einsum("s,dsr->dr", _SIX, values) / scale
        four = np.einsum("s,dsr->dr", _FOUR, values) / scale
        found.append((six, np.abs(six - four)))
    return Derivatives(*(np.concatenate(part).T for part in zip(*found, strict=True)))


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
    y[model.n_pos : model.n_pos + model.n_vel] += s * d.u
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
