"""Laws of time, curves y(x) and functions in Python: points in a case file, or in files beside it.

A run file holds all that a run needs, the points of its tables too. Columns that come from a file
and are long are kept as text (math/rows.py), in memory too.

`field_of` makes fields of the keys that kinds of joints, forces and integrators declare.
"""

import ast
from array import array
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    Field,
    PlainSerializer,
    ValidationInfo,
    WrapValidator,
    model_validator,
)

from ....dynamics.elements.joints.contract import Angle, DrivenBy
from ....errors import printable
from ....math import laws
from ....math.catalogue import (
    Code,
    Curve,
    Direction,
    Expression,
    Expressions,
    Number,
    OfTime,
    Three,
)
from ....math.disk_cache import file_sha256
from ....math.laws import Extrapolation, Interpolation, curve, curve_of_table
from ....math.rows import PREFIX, Packed, column, packed
from ...common.input_table import Axis, FilePath, Table, entry, optional
from ...common.text_file import lines_of, read_text
from ...common.units import LENGTHS, unit_of

# Keys of the validation context: the folder of the case file; whether tables are read already.
FOLDER, RESOLVED = "folder", "resolved"
LONG = 10_000  # rows from which on a column from a file is packed


def _kept(value: Any, check: Callable[[Any], Any], info: ValidationInfo) -> Any:
    """Leave a packed column as it is: one of a user's file is none."""
    resolved = bool((info.context or {}).get(RESOLVED))
    if isinstance(value, Packed) or (
        resolved and isinstance(value, str) and value.startswith(PREFIX)
    ):
        column(value)
        return value
    return check(value)


Times = Annotated[
    list[float], Field(min_length=2), WrapValidator(_kept), PlainSerializer(lambda value: value)
]


def read_columns(file: Path) -> tuple["list[float] | Packed", "list[float] | Packed"]:
    """Read times and values from a text file; header lines are ignored.

    Raises ValueError : no such file, a line without two numbers.
    """
    columns = array("d"), array("d")
    for number, line in lines_of(file):
        try:
            time, value = line.split(",")
            numbers = float(time), float(value)
        except ValueError as error:
            if not columns[0] and not any(letter.isdigit() for letter in line.split(",")[0]):
                continue  # names of the columns
            raise ValueError(
                f"{file} line {number}: expected two numbers with a comma, found {line.strip()!r}"
            ) from error
        columns[0].append(numbers[0])
        columns[1].append(numbers[1])
    if len(columns[0]) < LONG:
        return columns[0].tolist(), columns[1].tolist()
    return packed(np.frombuffer(columns[0])), packed(np.frombuffer(columns[1]))


def _read_by(
    file: Path, source: str, modules: dict[str, str], reads: dict[str, str]
) -> tuple[dict[str, str], dict[str, str]]:
    """Return texts of the modules beside a file that its source imports, and so on.

    And digests of the files that these name in quotes, by path.

    Raises ValueError : imports of a folder, or of a file of the current folder only.
    """
    try:
        nodes = list(ast.walk(ast.parse(source)))
    except (SyntaxError, ValueError, RecursionError):  # said when it is run
        return modules, reads
    texts = {n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)}
    for path in [at / text for text in texts for at in (file.parent, Path.cwd())]:
        with suppress(OSError, ValueError):  # no name of a file
            if path.is_file():
                reads[str(path.resolve())] = file_sha256(path)
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module}
    for name in sorted({name.split(".")[0] for name in names} - modules.keys()):
        beside = file.with_name(f"{name}.py")
        if beside.is_file():
            modules[name] = read_text(beside)
            _read_by(beside, modules[name], modules, reads)
        elif any(
            (at / name / "__init__.py").is_file() or (at / f"{name}.py").is_file()
            for at in (file.parent, Path.cwd())
        ):
            raise ValueError(
                f"{file} imports {name}, a folder or a file of the current folder, whose changes "
                "would go unnoticed; expected installed modules, and single files beside it"
            )
    return modules, reads


class PythonCode(Table):
    """`code` of a controller written in Python.

    `def NAME(t, inputs, memory)` returns the force. t [s] is the instant, `inputs` an array of the
    values of `inputs`, `memory` a dictionary that is kept from call to call and empty at the start.
    The file and what it imports from files beside it are read, not executed, when the case is
    checked; an edit of any of them, or of a file that they name in quotes, is noticed. Installed
    modules can be imported, too.
    """

    file: str = entry("Python file; path relative to the case file")
    function: str = entry("name of the function", default="control")
    source: str | None = optional("filled with the text of the file")
    modules: dict[str, str] = entry("filled with the texts of modules beside it", default={})
    reads: dict[str, str] = entry("filled with digests of files that it names", default={})

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        context = info.context or {}
        if context.get(RESOLVED) or not isinstance(data, dict):
            return data
        if extra := [key for key in ("source", "modules", "reads") if key in data]:
            raise ValueError(f"expected `file` and `function` only; found `{extra[0]}`")
        if not isinstance(data.get("file"), str):
            return data
        file = Path(context.get(FOLDER, ".")) / data["file"]
        source = read_text(file)
        modules, reads = _read_by(file, source, {}, {})
        return {**data, "source": source, "modules": modules, "reads": reads}


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
            given_laws = f"; found {' and '.join(given)}" if given else ""
            raise ValueError(f"expected one law of {', '.join(known)}{given_laws}")
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
    expression: str | None = optional("of `t` and of parameters, see expressions.md", "rad")


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
    expression: str | None = optional("of `t` and of parameters, see expressions.md", "m")

    more_lengths = ("polynomial", "table.values", "smooth_step.value")

    @model_validator(mode="before")
    @classmethod
    def _expression_in_metres(cls, data: Any, info: ValidationInfo) -> Any:
        text, unit = data.get("expression") if isinstance(data, dict) else None, unit_of(info)
        if unit == "m" or not isinstance(text, str):
            return data
        return {**data, "expression": f"({text})*{LENGTHS[unit]!r}"}


class LoadLaw(_Law):
    """`law` of a load, `actuator` of a spring: a force or torque over time."""

    constant: float | None = optional("the same at all times", "N or N m")
    polynomial: Coefficients | None = optional(
        "c0, c1, ... of c0 + c1 t + c2 t^2 + ...", "N, N/s, ..."
    )
    table: LoadTable | None = optional("values at given times")
    smooth_step: SmoothStep | None = optional("from 0 to a value")
    expression: str | None = optional(
        "of the time, coordinates and parameters, see expressions.md", "N or N m"
    )


class WindLaw(_Law):
    """`speed` of the wind: over time."""

    constant: float | None = optional("the same at all times", "m/s")
    polynomial: Coefficients | None = optional("c0, c1, ... of c0 + c1 t + ...", "m/s, m/s2, ...")
    smooth_step: SmoothStep | None = optional("from 0 to a speed")
    table: LoadTable | None = optional("values [m/s] at given times")
    expression: str | None = optional(
        "of the time `t` and of parameters, see expressions.md, such as 10 + 2*step(t - 5)", "m/s"
    )


def with_columns(data: Any, info: ValidationInfo, keys: tuple[str, str]) -> Any:
    """Return a table with both columns of its `file`, if it has one that is not read yet.

    Parameters
    ----------
    data : table as it was read
    info : context of the validation: folder of the file
    keys : names of both columns

    Raises
    ------
    ValueError : keys given beside the file, or as `read_columns`.
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


class StateEquation(Table):
    """`[states.NAME]`: a value by its differential equation, which expressions read as
    `state("NAME")`: filters, integrals, actuators of controllers.
    """

    rate: str = entry("expression of its rate by time")
    start: float = entry("value at the start", default=0.0)
    size: float = entry("order of its size, for the tolerance of its error", default=1.0, gt=0)


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


Z = [0.0, 0.0, 1.0]
NONE = [0.0, 0.0, 0.0]


def _not_zero(value: float | None) -> float | None:
    if value == 0.0:
        raise ValueError("expected a number other than 0")
    return value


Constants = Annotated[list[Annotated[float, Field(ge=0)]], Field(min_length=3, max_length=3)]


Key = Number | Three | Direction | DrivenBy | OfTime | Expression | Expressions | Curve | Code
# Types of keys other than numbers and drives.
TYPES: dict[type, Any] = {
    Three: Constants,
    Direction: Axis,
    OfTime: LoadLaw,
    Expression: str,
    Expressions: list[str],
    Curve: CurveTable,
    Code: PythonCode,
}


def field_of(key: Key) -> tuple[Any, Any]:
    """Return type and field of a key, as `create_model` takes them."""
    default = getattr(key, "default", None)
    unit = getattr(key, "unit", "")
    bounds: dict[str, object] = {}
    required = isinstance(key, Expressions | Code) or getattr(key, "required", False)
    if isinstance(key, Number):
        kind: Any = int if key.integer else float
        bounds = {"gt": key.above, "ge": key.least, "le": key.most}
    elif isinstance(key, DrivenBy):
        kind = RotationDrive if isinstance(key.drive.coordinate, Angle) else TranslationDrive
    else:
        kind = TYPES[type(key)]
    if isinstance(key, Three):
        default = NONE
    elif isinstance(key, Expressions):
        bounds = {"min_length": 1}
    elif isinstance(key, Direction):
        unit, default = "-", None if key.absent else Z
    if default is None and not required:
        kind = kind | None
    if isinstance(key, Number) and key.not_zero:
        kind = Annotated[kind, AfterValidator(_not_zero)]
    return kind, entry(key.meaning, unit, ... if required else default, **bounds)
