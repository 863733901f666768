"""A model as closures: what integrators that do not know a body are given."""

from collections.abc import Callable

import numpy as np

from ..dynamics.analysis.projection import projected
from ..dynamics.evaluation.derivative import by_blocks, dense_derivative_into, derivative_into
from ..dynamics.model.model import Model, state_size
from ..dynamics.model.workspace import spare_work
from ..math.arrays import Array
from .generic.base import Derivative


def right_hand_side(model: Model) -> Derivative:
    """Return f(t, y) -> dy/dt of the index-1 system, each time in the same array."""
    work, out = spare_work(model), np.empty(state_size(model))
    fill = derivative_into if by_blocks(model) else dense_derivative_into

    def rate(t: float, y: Array) -> Array:
        fill(model, work, t, y, out)
        return out

    return rate


def projection(model: Model) -> Callable[[float, Array], Array | None]:
    """Return project(t, y) -> state on the constraints; None if none is near."""
    work = spare_work(model)

    def nearest(t: float, y: Array) -> Array | None:
        out, reached = projected(model, t, y, work)
        return out if reached else None

    return nearest
