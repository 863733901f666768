"""Laws of time from the tables of a case."""

from dataclasses import replace
from typing import Any

from ..math import laws
from ..math.laws import Law


def law_of(table: dict[str, Any]) -> Law:
    """Return the law of a table that has exactly one (inputs/case/laws.py)."""
    offset = table.get("angle") or table.get("displacement") or 0.0
    given = {key: value for key, value in table.items() if value is not None}
    if "constant" in given:
        return laws.polynomial([given["constant"]])
    if "speed" in given:
        return laws.polynomial([offset, given["speed"]])
    if "polynomial" in given:
        return laws.polynomial(given["polynomial"])
    if "ramp" in given:
        rise = given["ramp"]
        sine = rise.get("shape") == "sine"
        return laws.ramp(rise["speed"], rise["duration"], offset, sine=sine)
    if "smooth_step" in given:
        step = given["smooth_step"]
        return laws.smooth_step(step["value"], step["duration"], step["start"])
    points = given["table"]
    smooth = points.get("interpolation", "spline") == "spline"
    return laws.table(points["times"], points["values"], smooth=smooth)


def shifted(law: Law, by: float) -> Law:
    """Return a law plus a constant."""
    coefficients = law.coefficients.copy()
    coefficients[:, 0] += by
    return replace(law, coefficients=coefficients)
