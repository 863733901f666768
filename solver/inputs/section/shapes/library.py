"""The library of parametric sections: from sizes and plies to the mesh that a shape needs."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ....errors import InputError, did_you_mean
from .airfoil import airfoil
from .solids import ellipse, rectangle, split_rectangle, tube
from .table import SHAPES, WEB, Parameter, Shape, Wall
from .walls import box, channel, i_section, two_cell

__all__ = ["SHAPES", "Parameter", "Shape", "Wall", "expand", "shape", "walls"]

Layers = Mapping[str, Sequence[float]]
Values = dict[str, Any]

MESHES: dict[str, Callable[[Values, dict[str, list[float]]], dict[str, Any]]] = {
    "rectangle": rectangle,
    "strip": rectangle,
    "split-rectangle": split_rectangle,
    "ellipse": ellipse,
    "tube": tube,
    "box": box,
    "two-cell": two_cell,
    "i": i_section,
    "channel": channel,
    "airfoil": airfoil,
}

_SKIN = {"curve": "outer"}


def shape(name: str) -> Shape:
    """Return the shape of a name; raises InputError with the nearest known one."""
    if name not in SHAPES:
        raise InputError(
            f'shape = "{name}": expected one of {", ".join(SHAPES)}{did_you_mean(name, SHAPES)}'
        )
    return SHAPES[name]


def walls(name: str, values: Mapping[str, Any]) -> tuple[Wall, ...]:
    """Regions of a shape; those of an airfoil depend on the number of its webs."""
    if name != "airfoil":
        return shape(name).walls
    n = len(_numbers(values.get("webs", ())))
    if n == 0:
        return (Wall("skin", _SKIN, "skin"),)
    caps = [Wall(f"cap-{side}", _SKIN, "cap") for side in ("upper", "lower")] if n > 1 else []
    webs = [Wall(f"web-{i}", WEB.direction, "web") for i in range(1, n + 1)]
    rear = Wall("skin-rear", _SKIN, "skin_rear")
    return (Wall("skin-front", _SKIN, "skin"), *caps, rear, *webs)


def expand(name: str, values: Mapping[str, Any], layers: Layers | None = None) -> dict[str, Any]:
    """The script of a shape and values for its parameters, with the default element counts.

    Parameters
    ----------
    name : key of SHAPES
    values : its sizes; for "contour" the coordinates themselves, (x, y) pairs
    layers : region -> thickness of each ply, outermost first, in any unit; a region that is left
        out has one

    Returns
    -------
    {"script": ..., "parameters": {key: number or list of numbers}}, for the airfoil also
    "coordinates"

    Raises
    ------
    InputError
        The text begins with the key: unknown, missing, out of bounds, or sizes that do not fit
        together.
    """
    table = _checked(shape(name), values)
    regions = [wall.region for wall in walls(name, table)]
    for region in layers or {}:
        if region not in regions:
            raise InputError(
                f"regions.{region}: the shape has no such region, expected "
                f"{', '.join(regions)}{did_you_mean(region, regions)}"
            )
    plies = {region: list((layers or {}).get(region, ())) or [1.0] for region in regions}
    return {"script": shape(name).script, **MESHES[name](table, plies)}


def _checked(shape: Shape, values: Mapping[str, Any]) -> Values:
    """All parameters of a shape, with defaults."""
    known = {parameter.key: parameter for parameter in shape.parameters}
    for key in values:
        if key not in known:
            raise InputError(
                f"{key}: unknown size of this shape, expected {', '.join(known)}"
                f"{did_you_mean(key, known)}"
            )
    table: Values = {}
    for key, parameter in known.items():
        value = values.get(key)
        if value is None:
            if parameter.required:
                raise InputError(f"{key}: missing, expected: {parameter.meaning}")
            table[key] = parameter.default
        else:
            table[key] = value if parameter.text else _in_bounds(parameter, value)
    return table


def _numbers(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else [value]


def _in_bounds(parameter: Parameter, value: Any) -> Any:
    for number in _numbers(value) if parameter.many else [value]:
        good = type(number) in (int, float) and math.isfinite(number)
        above, least, most = parameter.above, parameter.least, parameter.most
        good = good and (above is None or number > above) and (least is None or number >= least)
        if not good or (most is not None and number > most):
            limits = [
                f"{word} {limit:g}"
                for word, limit in (("above", above), ("from", least), ("up to", most))
                if limit is not None
            ]
            unit = "" if parameter.unit == "-" else f" [{parameter.unit}]"
            expected = " ".join(["a number", *limits]) + unit
            raise InputError(f"{parameter.key} = {value!r}: expected {expected}")
    return _numbers(value) if parameter.many else value
