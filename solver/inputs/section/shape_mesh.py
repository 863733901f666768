"""Sections of the library: plies of each wall, and the mesh for these plies."""

import math
from collections.abc import Mapping
from pathlib import Path

from ...errors import InputError, nearest, refuse
from ...package.specification import PlyTable, SectionMeshTable, SectionRegionTable
from ..common.table import plain_table
from .description import Region
from .mesh_table import ShapeMesh
from .shapes.contract import Values
from .shapes.library import Wall, expand, shape, walls
from .shapes.solid import few_across

ALL = "all"  # every wall or region without its own table
ADD_UP = 1e-6  # relative difference of plies and wall due to rounding

Stacks = Mapping[str, list[PlyTable]]  # plies of each region


def shape_mesh(
    mesh: ShapeMesh,
    regions: Mapping[str, Region],
    stacks: Stacks,
    folder: Path,
    *,
    where: str = "mesh",
    curved: bool = False,
) -> tuple[SectionMeshTable, dict[str, SectionRegionTable]]:
    """Return mesh and regions of the specification.

    Wall thicknesses that the description omits follow from the plies.

    Parameters
    ----------
    mesh : the shape
    regions : as described
    stacks : plies of each region; a region with another error may be missing
    folder : base of relative paths
    where : key of the shape, for messages
    curved : the beam has an initial twist or curvature

    Raises
    ------
    InputError
        Lines that begin with the key: unknown or missing walls, plies that do not add up, sizes
        that do not fit together.
    """
    values = mesh.values
    for key in (parameter.key for parameter in shape(mesh.shape).parameters if parameter.text):
        if key in values and (folder / values[key]).is_file():  # otherwise one of the library
            values[key] = str(folder / values[key])
    found: list[str] = []
    of_shape = walls(mesh.shape, values)
    names = [wall.region for wall in of_shape]
    for name in regions:
        if name not in (*names, ALL):
            found.append(f"regions.{name}: a {mesh.shape} has no such wall{nearest(name, names)}")
    expanded: dict[str, SectionRegionTable] = {}
    for wall in of_shape:
        key = wall.region if wall.region in regions else ALL
        if key not in regions:
            found.append(
                f"regions.{wall.region}: missing; a {mesh.shape} has the walls {', '.join(names)}"
            )
        elif key in stacks:
            found += _fit(wall, key, stacks[key], mesh.values, values)
            given = regions[key].direction
            direction = wall.direction if given is None else plain_table(given)
            expanded[wall.region] = {"plies": stacks[key], "direction": {**direction}}
    refuse(found)
    if len(expanded) < len(of_shape):  # reported elsewhere
        return {}, {}
    if curved and "elements_3" in {p.key for p in shape(mesh.shape).parameters}:
        few_across(values)
    layers = {
        name: [ply.get("thickness", 1.0) for ply in region["plies"]]
        for name, region in expanded.items()
    }
    try:
        return expand(mesh.shape, values, layers), expanded
    except InputError as error:
        raise InputError(f"{where}.{error}") from error


def _fit(wall: Wall, key: str, plies: list[PlyTable], given: Values, sizes: Values) -> list[str]:
    """Compare the plies with their wall and return errors, or add the wall to `sizes`."""
    if not wall.stacked or "thickness" not in plies[0]:
        return []
    total = math.fsum(ply["thickness"] for ply in plies)
    place = next((k for k in (wall.thickness, "wall", "skin") if k in given), wall.thickness)
    size = sizes.setdefault(place, total)
    if isinstance(size, list):  # one for each web
        number = int(wall.region.rpartition("-")[2]) - 1 if len(size) > 1 else 0
        size = size[number] if number < len(size) else total
    if abs(total - size) <= ADD_UP * size:
        return []
    return [
        f"regions.{key}: its {len(plies)} plies are {total:.9g} m thick in all, expected "
        f"mesh.{place} = {size:g} m"
    ]
