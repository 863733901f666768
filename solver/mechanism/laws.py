"""Laws of time from the tables of a case."""

from dataclasses import replace

from ..inputs.case.laws import LoadLaw, RotationDrive, TranslationDrive
from ..math import laws
from ..math.laws import Law


def law_of(given: RotationDrive | TranslationDrive | LoadLaw) -> Law:
    """Return the law of a table that has exactly one (inputs/case/laws.py)."""
    if given.polynomial is not None:
        return laws.polynomial(given.polynomial)
    if given.smooth_step is not None:
        step = given.smooth_step
        return laws.smooth_step(step.value, step.duration, step.start)
    if given.table is not None:
        smooth = not isinstance(given, LoadLaw) or given.table.interpolation == "spline"
        return laws.table(given.table.times or [], given.table.values or [], smooth=smooth)
    if isinstance(given, LoadLaw):
        return laws.polynomial([given.constant or 0.0])
    offset = given.angle if isinstance(given, RotationDrive) else given.displacement
    if given.ramp is not None:
        rise = given.ramp
        return laws.ramp(rise.speed, rise.duration, offset, sine=rise.shape == "sine")
    return laws.polynomial([offset, given.speed or 0.0])


def shifted(law: Law, by: float) -> Law:
    """Return a law plus a constant."""
    coefficients = law.coefficients.copy()
    coefficients[:, 0] += by
    return replace(law, coefficients=coefficients)
