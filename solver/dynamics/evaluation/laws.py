"""Values of the laws of time of a mechanism, at one time and at instants that change them."""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined
from ...math.laws import N_COEFFICIENT, law_value
from ..model.model import Model
from .measures import before_end, law_of_time


@inlined
def law_at(model: Model, law: int, t: float) -> tuple[float, float, float]:
    """Value and rates of a law at t; zeros where there is none."""
    if law < 0:
        return 0.0, 0.0, 0.0
    t = before_end(model.quantities, t)
    if model.quantities.law[law] >= 0:
        return law_of_time(model.quantities, model.quantities.law[law], t)
    return law_value(model.law_start, model.law_time, model.law_coefficient, law, t)


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
