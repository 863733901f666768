"""The library of parametric sections: mesh of a shape from its sizes and plies."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ....errors import InputError, did_you_mean
from ....math.catalogue import by_name, catalogue
from . import __name__ as _package
from . import __path__ as _path
from .contract import Parameter, Shape, Values, Wall

__all__ = ["SHAPES", "Parameter", "Shape", "Wall", "expand", "shape", "walls"]

Layers = Mapping[str, Sequence[float]]

_found = catalogue(_package, _path, Shape, besides=("library",))
SHAPES = by_name(
    [(s.name, s) for s in sorted(_found, key=lambda shape: (shape.order, shape.name))], "shape"
)


def shape(name: str) -> Shape:
    """Return the shape with this name; raises InputError with the nearest known name."""
    if name not in SHAPES:
        raise InputError(
            f'shape = "{name}": expected one of {", ".join(SHAPES)}{did_you_mean(name, SHAPES)}'
        )
    return SHAPES[name]


def walls(name: str, values: Mapping[str, Any]) -> tuple[Wall, ...]:
    """Regions of a shape of these sizes."""
    found = shape(name)
    return found.walls if found.walls_of is None else found.walls_of(values)


def expand(name: str, values: Mapping[str, Any], layers: Layers | None = None) -> dict[str, Any]:
    """The script of a shape and values for its parameters, with the default element counts.

    Parameters
    ----------
    name : key of SHAPES
    values : its sizes; for "contour" the coordinates themselves, (x, y) pairs
    layers : region -> thickness of each ply, outermost first, in any unit; an omitted region has
     one ply

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
    return {"script": shape(name).script, **shape(name).mesh(table, plies)}


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
