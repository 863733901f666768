"""Auxiliary states at the start of a run."""

import numpy as np

from ..math.arrays import Array
from ..math.expressions.program import NO_SEED, evaluated
from .model import Model
from .system import evaluate, measure_into
from .workspace import new_work


def started(model: Model, t: float, y: Array) -> Array:
    """Return the state y (n,) with the auxiliary states that a run starts with at time t.

    Angles are those of the position, within half a turn of what stood there; the others follow
    from their expressions, in their order.
    """
    if model.n_aux == 0:
        return y
    y, work, q = y.copy(), new_work(model), model.quantities
    first = model.n_pos + model.n_vel
    evaluate(model, work, t, y)
    for m in np.flatnonzero(q.turn >= 0):
        y[first + q.turn[m]] = work.quantity[2 * m]
    for j in np.flatnonzero(q.start_expression >= 0):
        measure_into(model, work, y)
        p = int(q.start_expression[j])
        y[first + j] = evaluated(q.programs, p, t, work.quantity, NO_SEED, NO_SEED, q.stack)[0]
    return y
