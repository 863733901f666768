"""Units of length of an input file: its lengths are converted to metres when they are read.

Lengths are the keys whose unit in the tables is m. All other keys keep their SI unit.
"""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from pydantic import ValidationInfo

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
Unit = Literal["m", "cm", "mm", "in"]
UNITS = "units"  # key of a file, and of the context of its validators
MEANING = "of all lengths in this file, the keys with the unit m; others keep theirs (docs/runs.md)"


def unit_of(info: "ValidationInfo") -> str:
    """Return the unit of lengths in the file that is being read."""
    return str((info.context or {}).get(UNITS, "m"))


def in_metres(value: Any, unit: str) -> Any:
    """Return a number, or lists of numbers, in metres; anything else as it is."""
    if isinstance(value, list):
        return [in_metres(each, unit) for each in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return value / (1.0 / LENGTHS[unit])  # 1e-3 is not exact, 1000 is


def with_metres(table: Any, unit: str, keys: Iterable[str]) -> Any:
    """Return a table with its lengths in metres, at keys such as "lower" or "table.values".

    Parameters
    ----------
    table : table as it was read
    unit : unit of its lengths
    keys : keys of its lengths, as "lower" or "table.values"
    """
    if unit == "m" or not isinstance(table, dict):
        return table
    converted = dict(table)
    for key in keys:
        first, _, rest = key.partition(".")
        if first in converted:
            inner = converted[first]
            converted[first] = with_metres(inner, unit, [rest]) if rest else in_metres(inner, unit)
    return converted


def own_scale(table: Any) -> Any:
    """Return a description whose mesh without `scale` is in the unit of the file."""
    unit, mesh = file_units(table).get(UNITS, "m"), isinstance(table, Mapping) and table.get("mesh")
    if unit == "m" or not isinstance(mesh, dict) or not {"file", "parameters"} & mesh.keys():
        return table
    return {**table, "mesh": {"scale": LENGTHS[unit], **mesh}}


def file_units(table: Any) -> dict[str, str]:
    """Return the context of validators for the units of a file; of a wrong value, those of SI."""
    unit = table.get(UNITS, "m") if isinstance(table, Mapping) else "m"
    return {UNITS: unit} if isinstance(unit, str) and unit in LENGTHS else {}
