"""Auxiliary states at the start of a run, and at instants at which controllers act."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..math.arrays import Array
from ..math.expressions.program import NO_SEED, evaluated
from .evaluation import evaluate, measure_into
from .model import Model
from .workspace import spare_work

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
