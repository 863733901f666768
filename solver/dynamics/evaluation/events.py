"""Auxiliary states: their start, and instants at which controllers act or levels are crossed."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array
from ...math.expressions.program import NO_SEED, evaluated
from ...math.laws import Hermite
from ..model.model import Model
from ..model.workspace import spare_work
from .evaluation import evaluate, measure_into

NOTHING = 1e-13  # part of a step: two instants closer than this are one
_PARTS = np.linspace(0.0, 1.0, 9)


def beyond(model: Model, t: float, y: Array) -> Array:
    """Return how far each coordinate is beyond its level, and the rate of that, (ne, 2)."""
    q, work = model.quantities, spare_work(model)
    evaluate(model, work, t, y)
    at, sign = q.event_coordinate, q.event_sign
    gap = sign * (work.quantity[2 * at] - q.event_level)
    return np.column_stack([gap, sign * work.quantity[2 * at + 1]])


def first_crossing(
    model: Model, t: Array, y: Array, armed: tuple[bool, ...]
) -> tuple[tuple[bool, ...], int, float]:
    """Look for the first event in steps with the ends t (k + 1,), y (k + 1, n).

    armed : of each event, whether its coordinate has been before its level since the last time

    Returns `armed` before that instant, the event, and the instant [s]; -1 without one. Between
    ends of a step coordinates are cubics by values and rates.
    """
    ready = np.array(armed)
    before = beyond(model, float(t[0]), y[0])
    for i in range(1, len(t)):
        after, h = beyond(model, float(t[i]), y[i]), float(t[i] - t[i - 1])
        gap = Hermite(0.0, 1.0, before[:, 0], h * before[:, 1], after[:, 0], h * after[:, 1])
        passed = (gap(_PARTS) > 0.0) & ready
        found = [
            (_root(gap, e, int(passed[:, e].argmax())), e)
            for e in np.flatnonzero(passed.any(axis=0)).tolist()
        ]
        if found:
            share, e = min(found)
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
NEAR = 1e-6  # periods by which an instant of two controllers may differ


def started(model: Model, t: float, y: Array) -> Array:
    """Return the state y (n,) with the auxiliary states that a run starts with at time t.

    Angles are those of the position, within half a turn of what stood there; the others follow
    from their expressions, in their order.
    """
    if model.n_aux == 0:
        return y
    y, work, q = y.copy(), spare_work(model), model.quantities
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)
    for m in np.flatnonzero(q.turn >= 0):
        y[first + q.turn[m]] = work.quantity[2 * m]
    for j in np.flatnonzero(q.start_expression >= 0):
        measure_into(model, work, y)
        p = int(q.start_expression[j])
        y[first + j] = evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]
    return sampled(model, t, y, q.period > 0.0)


def sampled(
    model: Model, t: float, y: Array, which: NDArray[np.bool_], functions: Sequence[Called] = ()
) -> Array:
    """Return the state y (n,) after the auxiliary states `which` (na,) have been sampled at t.

    functions : of the states `quantities.called`, of time and inputs (k,); without them these keep
        their values
    """
    q, work, after = model.quantities, spare_work(model), y.copy()
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)
    for c, function in enumerate(functions):
        if which[q.called[c]]:
            inputs = [
                evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]
                for p in range(int(q.call_start[c]), int(q.call_start[c + 1]))
            ]
            after[first + q.called[c]] = function(t, np.array(inputs))
    for j in np.flatnonzero(which & (q.update >= 0)):
        p = int(q.update[j])
        found = evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)
        after[first + j] = found[0]
    return after


class Instants:
    """When the auxiliary states of a model are sampled, after t = 0 and before t_end [s].

    Attributes
    ----------
    t : (k,) [s]
    """

    def __init__(self, model: Model, t_end: float) -> None:
        self._period = model.quantities.period
        periods = np.unique(self._period[self._period > 0.0])
        all_t = [p * np.arange(1, int(np.ceil(t_end / p - NEAR))) for p in periods]
        t = np.sort(np.concatenate([np.zeros(0), *all_t]))
        apart = np.diff(t, prepend=-1.0) > NEAR * periods.min(initial=1.0)
        self.t: Array = t[apart]

    def sampled_at(self, t: float) -> NDArray[np.bool_]:
        """Return which auxiliary states (na,) are sampled at an instant t."""
        period = np.where(self._period > 0.0, self._period, np.inf)
        turns = t / period
        return (self._period > 0.0) & (np.abs(turns - np.round(turns)) < NEAR)
