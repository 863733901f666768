"""Laws of time at one instant: values, rates and accelerations that can be changed one by one."""

import numpy as np

from ..math.arrays import Array
from ..math.laws import N_COEFFICIENT
from .laws import law_at
from .model import Model


def law_values(model: Model, t: float) -> Array:
    """Return value, rate and acceleration of every law at t, (n_law, 3)."""
    n = len(model.law_start) - 1
    return np.array([law_at(model, k, t) for k in range(n)], dtype=float).reshape(n, 3)


def with_laws(model: Model, t: float, values: Array) -> Model:
    """Return the model with laws that have these values (n_law, 3) at t."""
    n = len(values)
    coefficients = np.zeros((n, N_COEFFICIENT))
    coefficients[:, :3] = values * (1.0, 1.0, 0.5)
    return model._replace(
        law_start=np.arange(n + 1, dtype=np.int64),
        law_time=np.full(n, float(t)),
        law_coefficient=coefficients,
        quantities=model.quantities._replace(law=np.full(n, -1, dtype=np.int64)),
    )
