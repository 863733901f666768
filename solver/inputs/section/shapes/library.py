"""The library of parametric sections: mesh of a shape from its sizes and plies."""

from collections.abc import Mapping, Sequence
from typing import Any

from ....errors import InputError, did_you_mean
from ....math.catalogue import by_name, catalogue
from ....package.specification import SectionMeshTable
from . import __name__ as _package
from . import __path__ as _path
from .contract import Shape, Values, Wall

Layers = Mapping[str, Sequence[float]]

_found = catalogue(_package, _path, Shape, besides=("library",))
SHAPES = by_name(
    [(s.name, s) for s in sorted(_found, key=lambda shape: (shape.order, shape.name))], "shape"
)

THINNEST = 1e-6  # of the largest size; gmsh merges points at 1e-8 of the size of a script


def shape(name: str) -> Shape:
    """Return the shape with this name; raises InputError with the nearest known name."""
    if name not in SHAPES:
        raise InputError(
            f'shape = "{name}": expected one of {", ".join(SHAPES)}{did_you_mean(name, SHAPES)}'
        )
    return SHAPES[name]


def walls(name: str, values: Mapping[str, Any]) -> tuple[Wall, ...]:
    """Regions of a shape of these sizes."""
    chosen = shape(name)
    return chosen.walls if chosen.walls_of is None else chosen.walls_of(values)


def expand(name: str, values: Mapping[str, Any], layers: Layers | None = None) -> SectionMeshTable:
    """The script of a shape and values for its parameters, with the default element counts.

    Parameters
    ----------
    name : key of SHAPES
    values : its sizes, which the model of the shape has checked (mesh_table.py); for "contour" the
        coordinates themselves, (x, y) pairs
    layers : region -> thickness of each ply, outermost first, in any unit; an omitted region has
     one ply

    Returns
    -------
    {"script": ..., "parameters": {key: number or list of numbers}}, for the airfoil also
    "coordinates"

    Raises
    ------
    InputError
        The text begins with the key: sizes that do not fit together.
    """
    keys = {parameter.key: parameter for parameter in shape(name).parameters}
    given = {key: value for key, value in values.items() if value is not None}
    table: Values = {**{key: parameter.default for key, parameter in keys.items()}, **given}
    table |= {k: [v] for k, v in given.items() if keys[k].many and not isinstance(v, list)}
    regions = [wall.region for wall in walls(name, table)]
    for region in layers or {}:
        if region not in regions:
            raise InputError(
                f"regions.{region}: the shape has no such region, expected "
                f"{', '.join(regions)}{did_you_mean(region, regions)}"
            )
    sizes = [
        (min(v) if isinstance(v, list) else v, k)
        for k, v in given.items()
        if keys[k].unit == "m" and keys[k].above == 0.0
    ]
    (least, thin), (most, wide) = min(sizes, default=(1.0, "")), max(sizes, default=(1.0, ""))
    if least < THINNEST * most:
        raise InputError(
            f"{thin} = {least:g}: expected at least {THINNEST:g} of {wide} = {most:g} [m], below "
            "which gmsh takes points for one: are both in the same unit?"
        )
    plies = {region: list((layers or {}).get(region, ())) or [1.0] for region in regions}
    return {**shape(name).mesh(table, plies), "script": shape(name).script}
