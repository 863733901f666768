"""`[rotor]` of a case file: blades in the wind."""

import csv
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from pydantic import ValidationInfo, field_validator, model_validator

from ...common.input_table import (
    Axis,
    FilePath,
    Name,
    Table,
    Vector,
    entry,
    is_number,
    optional,
    usable_path,
)
from ...common.text_file import numbered_lines
from ...common.units import LENGTHS, unit_of
from .laws import FOLDER, RESOLVED, WindLaw

SECTION = ("chord", "width", "offset", "twist_deg")  # numbers of a row of `table`
POLAR = ("alpha_deg", "cl", "cd", "cm")
WIND = ("times", "speeds", "directions_deg")


class _Unreadable(str):
    """Name of a file that cannot be read."""

    why: str

    def __new__(cls, name: str, why: str) -> Self:
        self = super().__new__(cls, name)
        self.why = why
        return self


def _readable(value: Any) -> Any:
    if isinstance(value, _Unreadable):
        raise ValueError(value.why)
    return value


class RotorSection(Table):
    """A strip of a blade, about an interface; a row of the file `table`."""

    place: Name = entry("interface of the blades")
    chord: float = entry("of the airfoil", "m", gt=0)
    width: float = entry("of the strip along the blade", "m", gt=0)
    offset: float = entry("aerodynamic centre ahead of the interface, to the leading edge", "m")
    twist_deg: float = entry("about the line to the tip, from body y to the leading edge", "deg")
    polar: Name = entry("name of a polar")


class Polar(Table):
    """Coefficients of an airfoil over the angle of attack; rows of the file `polars`."""

    alpha_deg: list[float] = entry("rising, from -180 to 180", "deg", min_length=3)
    cl: list[float] = entry("lift")
    cd: list[float] = entry("drag")
    cm: list[float] = entry("moment about the aerodynamic centre, nose up")

    @model_validator(mode="after")
    def _whole(self) -> Self:
        angles = np.array(self.alpha_deg)
        if (np.diff(angles) <= 0.0).any():
            raise ValueError("alpha_deg: expected rising angles")
        if len({len(getattr(self, key)) for key in POLAR}) > 1:
            raise ValueError("expected as many of cl, cd and cm as angles")
        return self


class Wind(Table):
    """`[rotor.wind]`: the wind, the same at all points of one height."""

    one_of = ("speed", "file")

    speed: WindLaw | None = optional("at the reference height over time; or `file`", "m/s")
    file: FilePath | None = optional(
        "text file with the columns time [s], speed [m/s], direction [deg], separated by commas; "
        "path relative to the case file. Between its rows, straight lines"
    )
    times: list[float] | None = optional("filled from the file", "s")
    speeds: list[float] | None = optional("filled from the file", "m/s")
    directions_deg: list[float] | None = optional("filled from the file", "deg")
    direction: Axis = entry("to which it blows, global, across `up`", "-", [1.0, 0.0, 0.0])
    direction_deg: float = entry("turns `direction` about `up`", "deg", 0.0)
    up: Axis = entry("global; the ground is at height 0 of the origin", "-", [0.0, 0.0, 1.0])
    shear_exponent: float = entry("of the power law of speed over height", default=0.0, ge=0)
    reference_height: float = entry("height of the given speed", "m", 100.0, gt=0)

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, data: Any, info: ValidationInfo) -> Any:
        table, rows = _of(data, info, "file", WIND, (), WIND)
        return {**table, **{key: [row[key] for row in rows] for key in WIND}} if rows else table

    _file = field_validator("file", mode="before")(_readable)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if self.file is not None:
            times = np.array(self.times or [])
            if len(times) < 2 or (np.diff(times) <= 0.0).any() or times[0] > 0.0:
                raise ValueError(f'file = "{self.file}": expected rising times from 0 or before')
        up, along = (np.array(v) / np.linalg.norm(v) for v in (self.up, self.direction))
        if abs(float(up @ along)) > 1e-6:
            raise ValueError(f"direction = {self.direction}: expected a right angle to `up`")
        return self


class DividedBlade(Table):
    """A blade in segments, written by `check`."""

    places: dict[Name, str] = entry('interface of the blade -> "SEGMENT.INTERFACE"')
    rotation_deg: Vector = entry("rotation vector from global to blade axes at the start", "deg")


class Rotor(Table):
    """`[rotor]`: a rotor in the wind, by blade element momentum theory.

    Sections of all blades are loads on their interfaces. Induced velocities and separation are
    auxiliary states (docs/rotor.md).
    """

    hub: str = entry('"BODY.INTERFACE" at the centre of the rotor')
    axis: Axis = entry("of the shaft at the start, global", "-")
    blades: list[Name] = entry(
        "bodies with the interfaces of the sections: x to the tip, y to the leading edge, z to the "
        "suction side",
        min_length=1,
    )
    table: FilePath | None = optional(
        "instead of `sections`: a text file with the columns place, chord, width, offset, "
        "twist_deg and polar, separated by commas; path relative to the case file"
    )
    sections: list[RotorSection] = entry("from root to tip; or `table`", default=[], min_length=2)
    polar_table: FilePath | None = optional(
        "instead of `polars`: a text file with the columns polar, alpha_deg, cl, cd and cm"
    )
    polars: dict[Name, Polar] = entry("by name; or `polar_table`", default={})
    air_density: float = entry("of the air", "kg/m3", 1.225, gt=0)
    induction: Literal["buhl", "madsen"] = entry(
        "over the thrust of a ring. buhl: momentum theory with Buhl's relation of high thrust, as "
        "in AeroDyn and CCBlade; madsen: the polynomial of HAWC2, less induction at high thrust",
        default="buhl",
    )
    wind: Wind = entry("the wind")
    divided: dict[Name, DividedBlade] = entry(
        "blades in segments, written by `check`; not for users", default={}
    )

    @model_validator(mode="before")
    @classmethod
    def _from_files(cls, data: Any, info: ValidationInfo) -> Any:
        table, rows = _of(data, info, "table", SECTION, ("place", "polar"), ("sections",))
        if rows:  # files are in SI, what is checked below in the unit of the case
            per_metre = 1.0 / LENGTHS[unit_of(info)]
            lengths = ({key: float(row[key]) * per_metre for key in SECTION[:3]} for row in rows)
            table["sections"] = [{**row, **each} for row, each in zip(rows, lengths, strict=True)]
        table, rows = _of(table, info, "polar_table", POLAR, ("polar",), ("polars",))
        if rows:
            polars: dict[str, dict[str, list[float]]] = {}
            for row in rows:
                polar = polars.setdefault(str(row["polar"]), {key: [] for key in POLAR})
                for key in POLAR:
                    polar[key].append(float(row[key]))
            table["polars"] = polars
        return table

    _files = field_validator("table", "polar_table", mode="before")(_readable)

    @model_validator(mode="after")
    def _known(self) -> Self:
        if len(set(self.blades)) < len(self.blades):
            raise ValueError(f"blades = {self.blades}: expected each blade once")
        if not self.sections:
            raise ValueError("expected `table` or `sections`")
        return self


def _of(
    data: Any,
    info: ValidationInfo,
    key: str,
    numbers: tuple[str, ...],
    texts: tuple[str, ...],
    others: tuple[str, ...],
) -> tuple[Any, list[dict[str, float | str]]]:
    """Return a table, and the rows of the file at its key; none if it is not to be read now.

    In place of a file that cannot be read the table gets an `_Unreadable`, an error of this key.
    """
    context = info.context or {}
    if context.get(RESOLVED) or not isinstance(data, dict) or not isinstance(data.get(key), str):
        return data, []
    try:
        if given := [other for other in others if other in data]:
            raise ValueError(f"expected no `{given[0]}` with `{key}`")
        return dict(data), _rows(
            Path(context.get(FOLDER, ".")) / usable_path(data[key]), numbers, texts
        )
    except ValueError as error:
        return {**data, key: _Unreadable(data[key], str(error))}, []


def _rows(
    file: Path, numbers: tuple[str, ...], texts: tuple[str, ...]
) -> list[dict[str, float | str]]:
    """Return the rows of a file by column; without words, columns are in order, under any names
    but those of other columns.

    Raises
    ------
    ValueError : a missing column, a line without its numbers.
    """
    lines = numbered_lines(file)
    table = list(csv.reader(line for _, line in lines))
    columns = (*texts, *numbers)
    head = [name.strip() for name in table[0]] if texts and table else list(numbers)
    if missing := [name for name in columns if name not in head]:
        raise ValueError(f"{file}: column {missing[0]!r} is missing; expected {', '.join(columns)}")
    stems = [key[:4] for key in numbers]
    names = [name.strip().lower()[:4] for name in table[0]] if table and not texts else []
    if any(a in stems and a != b for a, b in zip(names, stems, strict=False)):
        order = ", ".join(numbers)
        raise ValueError(f"{file}: columns {','.join(table[0])!r}; expected {order} in this order")
    rows: list[dict[str, float | str]] = []
    for (line, _), row in zip(lines, table, strict=True):
        cells = dict(zip(head, (cell.strip() for cell in row), strict=False))
        if line == lines[0][0] and not is_number(cells.get(numbers[0], "")):
            continue  # names of the columns
        try:
            values = {key: float(cells[key]) for key in numbers}
        except (KeyError, ValueError) as error:
            text = f"expected numbers for {', '.join(numbers)}, found {','.join(row)!r}"
            raise ValueError(f"{file} line {line}: {text}") from error
        if len(row) != len(head) or not np.isfinite(list(values.values())).all():
            raise ValueError(f"{file} line {line}: expected {len(head)} finite values")
        rows.append({**{key: cells[key] for key in texts}, **values})
    return rows
