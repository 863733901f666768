"""Auxiliary states: their start, and instants at which they are sampled or levels are crossed."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, distinct
from ...math.expressions.program import NO_SEED, evaluated
from ...math.laws import Hermite
from ..model.model import (
    Model,
    spare_workspace,
)
from ..tolerances import ONE_SAMPLE
from .evaluation import evaluate, measure_into
from .laws import is_sampled
from .rotor import PASSES, move_inflow

_PARTS = np.linspace(0.0, 1.0, 9)


def beyond(model: Model, t: float, y: Array) -> Array:
    """Return how far each coordinate is beyond its level, and the rate of that, (ne, 2).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    q, work = model.quantities, spare_workspace(model)
    evaluate(model, work, t, y)
    at, sign = q.event_coordinate, q.event_sign
    gap = sign * (work.quantity[2 * at] - q.event_level)
    return np.column_stack([gap, sign * work.quantity[2 * at + 1]])


def first_crossing(
    model: Model, t: Array, y: Array, armed: tuple[bool, ...]
) -> tuple[tuple[bool, ...], int, float]:
    """Look for the first event in steps with the ends t (k + 1,), y (k + 1, n).

    Returns `armed` before that instant, the event, and the instant [s]; -1 without one. Between
    ends of a step coordinates are cubics by values and rates.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : ends of the steps (k + 1,) [s]
    y : states there (k + 1, n)
    armed : of each event, whether its coordinate has been before its level since the last time
    """
    ready = np.array(armed)
    before = beyond(model, float(t[0]), y[0])
    for i in range(1, len(t)):
        after, h = beyond(model, float(t[i]), y[i]), float(t[i] - t[i - 1])
        gap = Hermite(0.0, 1.0, before[:, 0], h * before[:, 1], after[:, 0], h * after[:, 1])
        passed = (gap(_PARTS) > 0.0) & ready
        crossings = [
            (_root(gap, e, int(passed[:, e].argmax())), e)
            for e in np.flatnonzero(passed.any(axis=0)).tolist()
        ]
        if crossings:
            share, e = min(crossings)
            return tuple(ready.tolist()), e, float(t[i - 1]) + share * h
        ready |= after[:, 0] < 0.0
        before = after
    return tuple(ready.tolist()), -1, 0.0


def _root(gap: Hermite, e: int, k: int) -> float:
    """Return the part of a step at which gap e first is positive; it is at part k of `_PARTS`."""
    low, high = (float(_PARTS[k - 1]), float(_PARTS[k])) if k else (0.0, 0.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if gap(middle)[e] > 0.0:
            high = middle
        else:
            low = middle
    return high


Called = Callable[[float, Array], float]


def started(model: Model, t: float, y: Array) -> Array:
    """Return the state y (n,) with the auxiliary states that a run starts with at time t.

    Angles are those of the position, within half a turn of what stood there; the others follow
    from their expressions, in their order; the inflow of a rotor is steady.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    if model.n_aux == 0:
        return y
    y, work, q = y.copy(), spare_workspace(model), model.quantities
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)
    for m in np.flatnonzero(q.turn >= 0):
        y[first + q.turn[m]] = work.quantity[2 * m]
    for j in np.flatnonzero(q.start_expression >= 0):
        measure_into(model, work, y)
        p = int(q.start_expression[j])
        y[first + j] = evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]
    for _ in range(PASSES if model.rotor.polar.size else 0):
        evaluate(model, work, t, y)
        if move_inflow(model, work.flow, y):
            break
    return sampled(model, t, y, q.period > 0.0)


def sampled(
    model: Model, t: float, y: Array, which: NDArray[np.bool_], functions: Sequence[Called] = ()
) -> Array:
    """Return the state y (n,) after the auxiliary states `which` (na,) have been sampled at t.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    which : states to sample (na,)
    functions : of the states `quantities.called`, of time and inputs (k,); without them these keep
        their values
    """
    q, work, after = model.quantities, spare_workspace(model), y.copy()
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)

    def value(p: int) -> float:
        return evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]

    for c, function in enumerate(functions):
        if which[q.called[c]]:
            inputs = [value(p) for p in range(*q.call_start[c : c + 2].tolist())]
            after[first + q.called[c]] = function(t, np.array(inputs))
    for j in np.flatnonzero(which & (q.update >= 0)):
        after[first + j] = value(int(q.update[j]))
    return after


class Instants:
    """When the auxiliary states of a model are sampled, behind `begin` and before t_end [s].

    An instant a rounding error behind `begin` is that of the begin itself, and not among them.

    Attributes
    ----------
    t : (k,) [s]
    """

    def __init__(self, model: Model, t_end: float, begin: float = 0.0) -> None:
        self._period = model.quantities.period
        if not (self._period > 0.0).any():
            self.t: Array = np.zeros(0)
            return
        periods = distinct(self._period[self._period > 0.0])
        all_t = [
            p * np.arange(int(begin / p + ONE_SAMPLE) + 1, int(np.ceil(t_end / p - ONE_SAMPLE)))
            for p in periods
        ]
        t = np.sort(np.concatenate([np.zeros(0), *all_t]))
        apart = np.diff(t, prepend=-1.0) > ONE_SAMPLE * periods.min(initial=1.0)
        self.t = t[apart]

    def sampled_at(self, t: float) -> NDArray[np.bool_]:
        """Return which auxiliary states (na,) are sampled at an instant t."""
        return np.array([is_sampled(p, t) for p in self._period.tolist()], dtype=bool)
