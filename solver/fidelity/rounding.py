"""Signals that are zero but for rounding, as motions across the plane of a planar mechanism."""

from collections.abc import Sequence

import numpy as np

from ..dynamics.model import Model
from ..dynamics.scales import extent
from ..math.arrays import Array

SILENT = 1e-12  # of the size of the mechanism
LENGTHS = ("position", "deflection")


def without_rounding(signals: Array, kinds: Sequence[str], model: Model, y0: Array) -> Array:
    """Return signals (o, k) with zeros for those of lengths that are zero to rounding.

    Their scale is 1 m then: relative to their largest value, which is rounding, no model would be
    accurate. Signals of other kinds stay, because no size is known to which they are small.

    Parameters
    ----------
    kinds : of the signals
    y0 : state at the start, for the size of the mechanism
    """
    least = SILENT * extent(model, y0)
    length = np.array([kind in LENGTHS for kind in kinds], dtype=bool)
    silent = length & (np.abs(signals).max(axis=1, initial=0.0) < least)
    return np.where(silent[:, None], 0.0, signals)
