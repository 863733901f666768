"""Values of the laws of a mechanism, of time."""

from ..math.compiled import inlined
from ..math.laws import law_value
from .measures import before_end, law_of_time
from .model import Model


@inlined
def law_at(model: Model, law: int, t: float) -> tuple[float, float, float]:
    """Value and rates of a law at t; zeros where there is none."""
    if law < 0:
        return 0.0, 0.0, 0.0
    t = before_end(model.quantities, t)
    if model.quantities.law[law] >= 0:
        return law_of_time(model.quantities, model.quantities.law[law], t)
    return law_value(model.law_start, model.law_time, model.law_coefficient, law, t)
