"""Laws of time and curves y(x) in a case file."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, model_validator

from ....errors import printable
from ....math import laws
from ....math.curves import Extrapolation, Interpolation, curve, curve_of_table
from ....math.rows import column
from ...common.table import FilePath, Table, entry, optional
from .columns import FOLDER, RESOLVED, Times, read_columns


class TimeTable(Table):
    """Points of a law of time."""

    file: FilePath | None = optional(
        "instead of `times` and `values`: a text file of two columns, time and value, separated "
        "by commas; path relative to the case file"
    )
    times: Times | None = optional("ascending, from 0 or before", "s")
    values: Times | None = optional("as many as times")

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, data: Any, info: ValidationInfo) -> Any:
        return with_columns(data, info, ("times", "values"))

    @model_validator(mode="after")
    def _usable(self) -> "TimeTable":
        if self.times is None or self.values is None:
            raise ValueError("expected `times` and `values`, or `file`")
        times, _ = laws.checked_points(column(self.times), column(self.values))
        if times[0] > 0.0:
            raise ValueError(f"times[0] = {times[0]:g}: expected 0 or before")
        return self


class DriveTable(TimeTable):
    """`table` of a drive: points of a smooth curve.

    After the last time the last value is kept: a table that ends before `solver.t_end` must end
    at rest.
    """

    interpolation: Literal["spline", "pchip"] = entry(
        "cubic spline, with a continuous acceleration; or a cubic that does not go beyond the "
        "values (pchip), whose acceleration jumps at the points",
        default="spline",
    )


class LoadTable(TimeTable):
    """`table` of a load or actuator.

    After the last time the last value is kept.
    """

    interpolation: Literal["linear", "pchip", "spline"] = entry(
        "straight lines; a smooth cubic that does not go beyond the values (pchip); or a cubic "
        "spline, for smooth data only: it goes far beyond the values of a short pulse",
        default="linear",
    )


class Ramp(Table):
    """`ramp` of a drive: from rest to a constant speed, smoothly."""

    speed: float = entry("final speed", "rad/s or m/s")
    duration: float = entry("time until it is reached", "s", gt=0)
    shape: Literal["polynomial", "sine"] = entry(
        "of the speed: smooth step of degree 5, or t/T - sin(2 pi t/T)/(2 pi)", default="polynomial"
    )


class SmoothStep(Table):
    """`smooth_step` of a law: from 0 to a value; rates begin and end at 0."""

    value: float = entry("reached at the end", "rad, m, N or N m")
    duration: float = entry("duration of the step", "s", gt=0)
    start: float = entry("time at which it begins", "s", 0.0, ge=0)


class _Law(Table):
    """One law out of several."""

    @model_validator(mode="after")
    def _one_law(self) -> "_Law":
        known = [n for n in type(self).model_fields if n in LAWS]
        given = [name for name in known if getattr(self, name) is not None]
        if len(given) != 1:
            found = f"; found {' and '.join(given)}" if given else ""
            raise ValueError(f"expected one law of {', '.join(known)}{found}")
        offset = getattr(self, "angle", 0.0) or getattr(self, "displacement", 0.0)
        if offset and given[0] not in ("speed", "ramp"):
            raise ValueError(
                f"expected an offset with speed or ramp only; found it with {given[0]}"
            )
        return self


LAWS = ("constant", "speed", "polynomial", "table", "ramp", "smooth_step", "expression")
Coefficients = Annotated[list[float], Field(min_length=1, max_length=laws.N_COEFFICIENT)]


class RotationDrive(_Law):
    """`drive` about an axis: the angle is prescribed by one law.

    Angles are zero in the given starting position and positive about the axis. They are rotations
    of the second place relative to the first.
    """

    speed: float | None = optional("constant angular velocity", "rad/s")
    ramp: Ramp | None = optional("from rest to a constant speed")
    angle: float = entry("angle at t = 0 of speed and ramp", "rad", 0.0)
    polynomial: Coefficients | None = optional(
        "c0, c1, ... of angle = c0 + c1 t + c2 t^2 + ...", "rad, rad/s, ..."
    )
    table: DriveTable | None = optional("angles [rad] at given times")
    smooth_step: SmoothStep | None = optional("from 0 to an angle")
    expression: str | None = optional("of the time `t` and of parameters, see forces.md", "rad")


class TranslationDrive(_Law):
    """`drive` along an axis: the displacement is prescribed by one law.

    Displacements are zero in the given starting position and positive along the axis. They are
    displacements of the second place relative to the first.
    """

    speed: float | None = optional("constant speed", "m/s")
    ramp: Ramp | None = optional("from rest to a constant speed")
    displacement: float = entry("displacement at t = 0 of speed and ramp", "m", 0.0)
    polynomial: Coefficients | None = optional(
        "c0, c1, ... of displacement = c0 + c1 t + c2 t^2 + ...", "m, m/s, ..."
    )
    table: DriveTable | None = optional("displacements [m] at given times")
    smooth_step: SmoothStep | None = optional("from 0 to a displacement")
    expression: str | None = optional("of the time `t` and of parameters, see forces.md", "m")


class LoadLaw(_Law):
    """`law` of a load, `actuator` of a spring: a force or torque over time."""

    constant: float | None = optional("the same at all times", "N or N m")
    polynomial: Coefficients | None = optional(
        "c0, c1, ... of c0 + c1 t + c2 t^2 + ...", "N, N/s, ..."
    )
    table: LoadTable | None = optional("values at given times")
    smooth_step: SmoothStep | None = optional("from 0 to a value")
    expression: str | None = optional(
        "of the time, coordinates and parameters, see forces.md", "N or N m"
    )


def with_columns(data: Any, info: ValidationInfo, keys: tuple[str, str]) -> Any:
    """Return a table with both columns of its `file`, if it has one that is not read yet.

    Raises ValueError : keys given beside the file, or as `read_columns`.
    """
    if not isinstance(data, dict) or not isinstance(data.get("file"), str):
        return data
    if (info.context or {}).get(RESOLVED) or printable(data["file"]) != data["file"]:
        return data
    if any(key in data for key in keys):
        raise ValueError(f"expected either `file` or `{keys[0]}` and `{keys[1]}`")
    folder = Path((info.context or {}).get(FOLDER, "."))
    return {**data, **dict(zip(keys, read_columns(folder / data["file"]), strict=True))}


class CurveTable(Table):
    """`force_displacement`, `force_velocity`: points of a curve.

    Beyond its ends it goes on straight.
    """

    x: Times = entry("ascending", "m, rad, m/s, rad/s")
    y: Times = entry("as many as x", "N or N m")
    interpolation: Literal["spline", "linear"] = entry(
        "cubic spline, or straight lines", default="spline"
    )

    @model_validator(mode="after")
    def _usable(self) -> "CurveTable":
        curve(column(self.x), column(self.y))
        return self


class TablePoints(Table):
    """`[tables.NAME]`: a curve through points, which expressions call as `NAME(...)`."""

    file: FilePath | None = optional(
        "instead of `x` and `y`: a text file of two columns, separated by commas; path relative "
        "to the case file"
    )
    x: Times | None = optional("ascending")
    y: Times | None = optional("as many as x")
    interpolation: Interpolation = entry(
        "straight lines; a cubic spline; or a cubic without overshoot between points (pchip)",
        default="cubic",
    )
    extrapolation: Extrapolation = entry(
        "beyond both ends: straight on, or the value of the end", default="linear"
    )

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, data: Any, info: ValidationInfo) -> Any:
        return with_columns(data, info, ("x", "y"))

    @model_validator(mode="after")
    def _usable(self) -> "TablePoints":
        if self.x is None or self.y is None:
            raise ValueError("expected `x` and `y`, or `file`")
        curve_of_table(column(self.x), column(self.y), self.interpolation, self.extrapolation)
        return self
