"""Whether curves through the points of tables go far beyond these points."""

from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING

from ..inputs.case.of_time import drives, is_along, is_load, law
from ..math import curves, laws
from ..math.packed import column
from ..results.codes import TABLE_OVERSHOOTS
from ..results.finding import Finding
from .finished import FinishedRun

if TYPE_CHECKING:
    from ..inputs.case import laws as laws_of_case
    from ..inputs.case.schema import Mechanism

Beyond = tuple[str, float, str]  # key of a table, its overshoot, what does not overshoot


def table_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the tables whose cubic splines leave the range of their values."""
    found = chain(_of_time(run.mechanism), _of_curves(run.mechanism))
    for key, share, others in found:
        if share > TABLE_OVERSHOOTS.limit:
            text = (
                f"{key}: the cubic spline goes beyond the values of the table by {share:.0%} of "
                f"their range (expected at most {TABLE_OVERSHOOTS.limit:.0%}). {others}"
            )
            yield TABLE_OVERSHOOTS.finding(text, value=share)


def _of_time(mechanism: "Mechanism") -> Iterator[Beyond]:
    given = {
        f"joints.{name}.{key}": drive
        for name, joint in mechanism.joints.items()
        for key, drive in drives(joint).items()
    }
    remedy = 'interpolation = "pchip" does not; more points, or smooth_step, make it smaller'
    for key, drive in given.items():
        if drive.table is not None:
            yield f"{key}.table", _share(drive.table), remedy
    remedy = 'interpolation = "linear" and "pchip" do not'
    for name, force in mechanism.forces.items():
        load = law(force)
        if load is not None and load.table is not None:
            key = "law" if is_load(force) else "actuator"
            yield f"forces.{name}.{key}.table", _share(load.table), remedy


def _share(table: "laws_of_case.DriveTable | laws_of_case.LoadTable") -> float:
    if table.interpolation != "spline":
        return 0.0  # such curves stay within the values
    times, values = column(table.times), column(table.values)
    return laws.overshoot(laws.table(times, values, table.interpolation), values)


def _of_curves(mechanism: "Mechanism") -> Iterator[Beyond]:
    remedy = 'interpolation = "linear" does not'
    for name, force in mechanism.forces.items():
        if not is_along(force):
            continue
        for key in ("force_displacement", "force_velocity"):
            given = getattr(force, key, None)
            if given is not None:
                through = curves.curve(given.x, given.y, smooth=given.interpolation == "spline")
                yield f"forces.{name}.{key}", laws.overshoot(through, given.y, 1), remedy
    remedy = 'interpolation = "pchip" and "linear" do not'
    for name, points in mechanism.tables.items():
        if points.interpolation != "cubic":
            continue
        x, y = column(points.x), column(points.y)
        through = curves.curve_of_table(x, y, points.interpolation, points.extrapolation)
        yield f"tables.{name}", laws.overshoot(through, y, 1), remedy
