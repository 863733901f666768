"""Laws of time from the tables of a case."""

from dataclasses import replace
from typing import TYPE_CHECKING

from ..inputs.case.expressions import CaseScope, expression
from ..math import laws
from ..math.expressions.tree import constant
from ..math.laws import Law
from ..math.packed import column

if TYPE_CHECKING:
    from ..inputs.case.laws import LoadLaw, RotationDrive, TranslationDrive
    from ..inputs.case.schema import Mechanism


def drive_law(given: "RotationDrive | TranslationDrive", mechanism: "Mechanism", key: str) -> Law:
    """Return the law of a drive, which may be an expression of the time."""
    if given.expression is not None:
        scope = CaseScope(mechanism)
        return laws.of_expression(expression(given.expression, scope, f"{key}.expression"))
    return law_of(given)


def law_of(given: "RotationDrive | TranslationDrive | LoadLaw") -> Law:
    """Return the law of a table that has exactly one (inputs/case/laws.py), no expression."""
    if given.polynomial is not None:
        return laws.polynomial(given.polynomial)
    if given.smooth_step is not None:
        step = given.smooth_step
        return laws.smooth_step(step.value, step.duration, step.start)
    if given.table is not None:
        points = column(given.table.times), column(given.table.values)
        return laws.table(*points, given.table.interpolation)
    # Keys that only some of the tables have.
    keys = {key: getattr(given, key, None) for key in ("constant", "ramp", "speed")}
    offset = getattr(given, "angle", 0.0) or getattr(given, "displacement", 0.0)
    if keys["constant"] is not None:
        return laws.polynomial([keys["constant"]])
    if keys["ramp"] is not None:
        rise = keys["ramp"]
        return laws.ramp(rise.speed, rise.duration, offset, sine=rise.shape == "sine")
    return laws.polynomial([offset, keys["speed"] or 0.0])


def shifted(law: Law, by: float) -> Law:
    """Return a law plus a constant."""
    if law.expression is not None:
        return replace(law, expression=law.expression + constant(by))
    coefficients = law.coefficients.copy()
    coefficients[:, 0] += by
    return replace(law, coefficients=coefficients)
