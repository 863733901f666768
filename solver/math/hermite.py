"""The cubic between two times that has given values and slopes at both."""

from typing import Any

import numpy as np

from .arrays import Array


class Hermite:
    """The cubic through values and slopes at both ends of a step."""

    def __init__(
        self, t_old: float, h: float, y_0: Array, f_0: Array, y_1: Array, f_1: Array
    ) -> None:
        self.t_old, self.h, self.y_0, self.f_0, self.y_1, self.f_1 = t_old, h, y_0, f_0, y_1, f_1

    def __call__(self, t: Any) -> Array:
        """State at times t (...,), (..., n)."""
        x = ((np.asarray(t, dtype=float) - self.t_old) / self.h)[..., None]
        rise = x * x * (3 - 2 * x)
        bent = x * (1 - x) * self.h
        answer: Array = (
            (1 - rise) * self.y_0
            + rise * self.y_1
            + bent * (1 - x) * self.f_0
            - bent * x * self.f_1
        )
        return answer
