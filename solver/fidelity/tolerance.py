"""What the tolerance of the integrator costs: errors of signals by those of the modes."""

import numpy as np

from ..dynamics.scales import extent, shape_sizes
from ..math.arrays import Array
from .effects import Effects
from .response import Response


def amplified_errors(found: Response, parts: Effects, scale: Array) -> Array:
    """Return the error (o,) of the signals over the tolerance of the integrator, of the scale.

    A tolerance of 1 permits errors of the modes that displace a body by the size of the mechanism.
    What the modes of a body add to a signal has that size over their displacement as its error.
    """
    model, q = found.model, found.history[0]
    size, first, worst = extent(model, found.y[0]), 0, np.zeros(len(scale))
    for i in range(model.n_body):
        m = int(model.n_mode[i])
        mine = slice(first, first + m)
        moved = float(np.linalg.norm(q[:, mine] * shape_sizes(model, i), axis=1).max(initial=0.0))
        first += m
        if moved > 0.0:
            added = np.abs(parts.response[:, :, mine].sum(axis=2)).max(axis=1) / scale
            worst = np.maximum(worst, added * size / moved)
    return worst
