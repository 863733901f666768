"""Descriptions of sections with other values at some keys, and studies that vary them."""

import csv
import itertools
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from ...errors import InputError, nearest
from ..common.input_table import Table, entry, is_number, optional, validated
from ..common.text_file import read_toml
from .specification import section_spec
from .vabs import is_of_another_code, spec_of_another_code

# Change of keys of a section description.


def changed(table: dict[str, object], changes: Mapping[str, Any], file: Path) -> dict[str, object]:
    """Return the table of a description with other values.

    Parameters
    ----------
    changes : dotted key, with numbers for positions in a list, and its value
    file : of the table, for messages

    Raises
    ------
    InputError : a key that does not exist.
    """
    table = deepcopy(table)
    for key, value in changes.items():
        place, last = _place(table, key, file)
        place[last] = value
    return table


def _place(table: dict[str, object], key: str, file: Path) -> tuple[Any, str | int]:
    """Return the table or list of a dotted key, and its last part; see `changed`."""
    *path, end = _parts(key)
    place: Any = table
    for i, part in enumerate(path):
        if _at(place, part) not in _known(place):
            raise InputError(
                f"{file}: {'.'.join(path[: i + 1])}: no such table, needed for the change of "
                f'"{key}"{nearest(part, map(str, _known(place)))}'
            )
        place = place[_at(place, part)]
    last = _at(place, end)
    if not isinstance(place, dict) and last not in _known(place):
        raise InputError(f'{file}: {".".join(path)}: has no {end}, the change of "{key}"')
    return place, last


@lru_cache(maxsize=4096)  # members of a sweep change the same keys
def _parts(key: str) -> list[str]:
    """Return the parts of a dotted key, by the rules of TOML."""
    parts: list[str] = []
    try:
        inner: Any = tomllib.loads(f"{key} = 0")
        while isinstance(inner, dict):
            ((part, inner),) = inner.items()
            parts.append(part)
    except ValueError as error:
        raise InputError(f'sweep.key = "{key}": not a dotted key of TOML: {error}') from error
    return parts


def _at(place: Any, part: str) -> str | int:
    return int(part) if isinstance(place, list) and part.isdecimal() else part


def _known(place: Any) -> list[Any]:
    """Keys of a table, positions of a list; none of a value."""
    if isinstance(place, dict):
        return list(place)
    return list(range(len(place))) if isinstance(place, list) else []


# A study: descriptions of sections and the keys that are varied.
#
# format = 1
# sections = ["box.toml", "tube.toml"]      # descriptions, beside this file
# combine = "product"                       # of the sweeps; or "zip": one value of each
#
# [[sweep]]
# key = "laminates.wall.angles_deg"         # a key of the descriptions
# values = [[0, 0], [15, -15], [30, -30]]
# names = ["a", "b", "c"]                   # optional: parts of the sections' names
#
# [[sweep]]
# key = "laminates.wall.angles_deg"
# csv = "angles.csv"                        # rows of numbers, or "name, 1, 2" and "soft, 45, -45"

FileName = Annotated[str, Field(pattern=r"^[\w.+-]+$")]  # it becomes part of a folder's name
Variants = list[tuple[str, dict[str, object]]]  # end of the name, dotted keys with their values


class Sweep(Table):
    """`[[sweep]]`: a key of the descriptions and its values."""

    one_of = ("values", "csv")

    key: str = entry("dotted key, as in a description", min_length=1)
    values: list[Any] | None = optional("its values", min_length=1)
    csv: str | None = optional("file with a value in each row")
    names: list[FileName] | None = optional("a short name for each value")

    @model_validator(mode="after")
    def _one_source(self) -> "Sweep":
        if self.names is not None and (self.csv or len(self.names) != len(self.values or ())):
            raise ValueError("expected as many `names` as `values`")
        return self


class Study(Table):
    """A batch list in TOML."""

    format: Literal[1] = entry("version of this format")
    title: str = entry("one line", default="")
    sections: list[str] = entry("descriptions to vary, beside this file", min_length=1)
    combine: Literal["product", "zip"] = entry(
        "all combinations of the sweeps, or one value of each", default="product"
    )
    sweep: list[Sweep] = entry("keys to vary", default=[])


def study_variants(path: Path, table: Mapping[str, Any]) -> tuple[Study, Variants]:
    """Check a study; return it with the changes of each of its variants.

    Raises
    ------
    InputError : a wrong key or value, sweeps of different length, a wrong CSV file.
    """
    study = validated(Study, table, path)
    return study, _combinations(path, study)


def _combinations(path: Path, study: Study) -> Variants:
    """Suffix of the name and changes of each combination."""
    if not study.sweep:
        return [("", {})]
    columns = [_column(path, i, sweep) for i, sweep in enumerate(study.sweep)]
    if study.combine == "zip":
        counts = [len(column) for column in columns]
        if len(set(counts)) > 1:
            raise InputError(
                f'{path}: combine = "zip": expected as many values in each sweep, found {counts}'
            )
        rows: Sequence[Any] = list(zip(*columns, strict=True))
    else:
        rows = list(itertools.product(*columns))
    named = all(name for row in rows for name, _ in row)
    digits = len(str(len(rows)))
    variants = []
    for number, row in enumerate(rows, start=1):
        suffix = "-".join(name for name, _ in row) if named else f"{number:0{digits}d}"
        changes = {sweep.key: value for sweep, (_, value) in zip(study.sweep, row, strict=True)}
        variants.append((f"-{suffix}", changes))
    ((suffix, count),) = Counter(suffix for suffix, _ in variants).most_common(1)
    if count > 1:
        raise InputError(f'{path}: sweep: the name "{suffix[1:]}" occurs {count} times')
    return variants


def _column(path: Path, index: int, sweep: Sweep) -> list[tuple[str, Any]]:
    """Name (may be empty) and value of each row of a sweep."""
    if sweep.csv is None:
        values = sweep.values or []
        return list(zip(sweep.names or [""] * len(values), values, strict=True))
    file = path.parent / sweep.csv
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            rows = [[cell.strip() for cell in row] for row in csv.reader(stream)]
    except (FileNotFoundError, UnicodeDecodeError) as error:
        key = f"{path}: sweep.{index}.csv"
        raise InputError(f'{key} = "{sweep.csv}": no such table') from error
    rows = [row for row in rows if any(row) and not row[0].startswith("#")]
    column = []
    for number, row in enumerate(rows, start=1):
        name, cells = ("", row) if is_number(row[0]) else (row[0], row[1:])
        cells = [cell for cell in cells if cell]
        bad = next((cell for cell in cells if not is_number(cell)), None)
        if number == 1 and (name.lower() == "name" or bad is not None or not cells):
            continue  # names of the columns
        if bad is not None or not cells:
            raise InputError(f"{file}: row {number}: expected numbers, found {bad or 'none'!r}")
        if name and not re.fullmatch(r"[\w.+-]+", name):
            raise InputError(
                f"{file}: row {number}: {name!r}: expected a name of letters, digits and _.+-"
            )
        column.append((name, [float(cell) for cell in cells]))
    if not column:
        raise InputError(f"{file}: there is no row of numbers")
    return column


# Parameters of a description: the numbers of the specification that follow from them.

STEP = 5e-4  # of a number, for difference quotients
ROUNDING = 1e-13  # of a number: a change below it is none
RIGHT_ANGLE = 90.0  # deg: the size of an angle
POINTS = ((-2.0, -1.0, 0.0, 1.0, 2.0), (0.0, 1.0, 2.0, 3.0, 4.0), (0.0, -1.0, -2.0, -3.0, -4.0))
Parameters = Mapping[str, Mapping[str, float]]  # name -> dotted key and factor of each target
Leaves = dict[tuple[str | int, ...], Any]  # values of nested tables and lists by their keys


def design_of(
    table: dict[str, object], file: Path, folder: Path, asked: Parameters
) -> dict[str, list[dict[str, object]]]:
    """Return the targets of parameters in the specification: key and change per unit.

    A thickness of a description moves thicknesses of plies and sizes of the mesh at once.

    Parameters
    ----------
    table : the description
    file : its file, for messages
    folder : folder for relative names of files
    asked : factor of each key, by parameter

    Raises
    ------
    InputError : a key that does not exist or is no number; a number of elements that changes.
    """
    parameters = {}
    for name, factors in asked.items():
        values = {key: _number(table, key, file) for key in factors}
        sizes = [
            (RIGHT_ANGLE if key.endswith("deg") or "angles_deg" in key else abs(value) or 1.0)
            / abs(factors[key])
            for key, value in values.items()
        ]
        step = STEP * min(sizes)

        moves = {key: (value, step * factors[key]) for key, value in values.items()}

        def leaves(place: float, moves: dict[str, tuple[float, float]] = moves) -> Leaves:
            moved = {key: value + place * move for key, (value, move) in moves.items()}
            try:
                return leaves_of(section_spec(changed(table, moved, file), file, folder))
            except InputError as error:
                if not place:
                    raise
                said = str(error).partition(f"{file}: ")[2]
                raise InputError(f"{file}: {', '.join(moves)}: changed alone, {said}") from error

        rates, here = _rates(leaves)
        if rates is None:
            raise InputError(
                f"{file}: {', '.join(factors)}: a number of elements changes on both sides of this "
                "value, so that there is no derivative; expected a slightly different one"
            )
        parameters[name] = [
            {"of": [*map(str, path)], "factor": float(f"{rate / step:.13g}")}
            for path, rate in rates.items()
            if abs(rate) > ROUNDING * abs(here[path])
        ]
        if not parameters[name]:
            raise InputError(f"{file}: {', '.join(factors)}: expected a number that has an effect")
    return parameters


def _rates(leaves: Callable[[float], Leaves]) -> tuple[Leaves | None, Leaves]:
    """Return rates of all numbers but whole ones, and their values.

    Where whole numbers, of elements, change on one side, the other counts; None: on both.
    """
    here = leaves(0.0)
    fixed = {path: value for path, value in here.items() if not isinstance(value, float)}
    for places in POINTS:
        at = [leaves(place) if place else here for place in places]
        if all(one.keys() == here.keys() and fixed.items() <= one.items() for one in at):
            weights = np.linalg.solve(np.vander(places, increasing=True).T, np.eye(len(places))[1])
            numbers = here.keys() - fixed.keys()
            rows = {path: [one[path] - here[path] for one in at] for path in numbers}
            return {path: float(weights @ rows[path]) for path in here if path in numbers}, here
    return None, here


def _number(table: dict[str, object], key: str, file: Path) -> float:
    place, last = _place(table, key, file)
    value: Any = place.get(last) if isinstance(place, dict) else place[last]
    if not is_number(str(value)) or isinstance(value, str):
        raise InputError(f"{file}: {key} = {value!r}: expected a number in the description")
    return float(value)


def leaves_of(spec: Any, path: tuple[str | int, ...] = ()) -> Leaves:
    """Return all values of nested tables and lists by their keys."""
    pairs = spec.items() if isinstance(spec, dict) else enumerate(spec)
    leaves: Leaves = {}
    for key, value in pairs:
        nested = isinstance(value, dict | list)
        leaves |= leaves_of(value, (*path, key)) if nested else {(*path, key): value}
    return leaves


def described_spec(
    file: Path,
    changes: Mapping[str, Any],
    name: str,
    folder: Path,
    derivatives: Parameters | None = None,
) -> dict[str, object]:
    """Return the specification of a description with changes.

    Parameters
    ----------
    changes : other values at dotted keys
    name : of the section if there are changes
    folder : where meshes of the description are written
    derivatives : parameters by which everything is differentiated, in the key `design`

    Raises
    ------
    InputError : the description, a change or a parameter is wrong.
    """
    if is_of_another_code(file) and not changes:
        if derivatives:
            raise InputError(f"{file}: derivatives are for descriptions of sections (TOML)")
        return spec_of_another_code(file, folder)
    table = read_toml(file, "section description")
    try:
        table = changed(table, changes, file)
        spec = section_spec(table, file, folder)
        design = design_of(table, file, folder, derivatives) if derivatives else {}
    except InputError as error:
        if not changes:
            raise
        lines = str(error).splitlines()
        raise InputError("\n".join(f"{name}: {line}" for line in lines)) from error
    return spec | ({"name": name} if changes else {}) | ({"design": design} if design else {})
