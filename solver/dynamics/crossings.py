"""Instants at which coordinates pass levels: events that auxiliary states follow.

An event belongs to a state that takes a new value when its coordinate passes a level in one
direction, such as the speed of an impact where a joint meets its stop.
"""

import numpy as np

from ..math.arrays import Array
from ..math.hermite import Hermite
from .evaluation import evaluate
from .model import Model
from .workspace import spare_work

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
