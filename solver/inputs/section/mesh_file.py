"""Sections on a user's mesh: gmsh's files are passed on, others are converted to arrays."""

import os
from pathlib import Path
from typing import Any

from ...errors import InputError, few, nearest, refuse
from ...package.specification import SectionMeshTable, SectionRegionTable
from ..common.gmsh_file import content_sha256, is_gmsh_mesh, mesh_source, physical_names
from ..common.table import plain_table
from .description import Region, SectionDescription
from .foreign import assign_regions, read_foreign, write_arrays
from .mesh_table import FileMesh
from .shape_mesh import ALL, Stacks

Regions = dict[str, Region]
Names = dict[str, str]  # region of the mesh -> its description


def file_mesh(
    description: SectionDescription, stacks: Stacks, folder: Path, arrays_folder: Path
) -> tuple[SectionMeshTable, dict[str, SectionRegionTable]]:
    """Return mesh and regions of the specification.

    Parameters
    ----------
    description : with a mesh file
    stacks : plies of each region; a region with another error may be missing
    folder : base of relative paths
    arrays_folder : where the arrays of a foreign mesh are written

    Raises
    ------
    InputError
        Lines that begin with the key: no such file, unknown or missing regions and curves, missing
        layer directions.
    """
    table, regions = description.mesh, description.regions
    assert isinstance(table, FileMesh)
    file, _ = mesh_source(table.file, folder)
    found = [line for name, region in regions.items() for line in _direction(name, region, stacks)]
    try:
        if file.suffix == ".geo" or (file.suffix == ".msh" and is_gmsh_mesh(file)):
            mesh, names = _of_gmsh(file, table, regions)
        else:
            mesh, names = _of_others(file, table, regions, arrays_folder)
    except InputError as error:
        raise InputError("\n".join([*str(error).splitlines(), *found])) from error
    refuse(found)
    if table.scale is not None:
        mesh["scale"] = table.scale
    expanded: dict[str, SectionRegionTable] = {}
    for name, described in names.items():
        if described in stacks:
            expanded[name] = {"plies": stacks[described]}
            direction = regions[described].direction
            if direction is not None:
                expanded[name]["direction"] = plain_table(direction)
    return mesh, expanded


def _of_gmsh(file: Path, table: FileMesh, regions: Regions) -> tuple[SectionMeshTable, Names]:
    """Return a mesh or script of gmsh, and the description of each of its regions."""
    script = file.suffix == ".geo"
    found = []
    if table.region_data is not None:
        found.append(
            f'mesh.region_data = "{table.region_data}": expected no such key, the regions of '
            f"{table.file} are its physical surfaces"
        )
    mesh: SectionMeshTable = {"file": os.path.relpath(file), "sha256": content_sha256(file)}
    if script:
        if table.parameters is not None:
            mesh["parameters"] = table.parameters
        names = {name: name for name in regions}  # `all`: gmsh will know the others
    else:
        surfaces, curves = physical_names(file, f'mesh.file = "{table.file}"')
        names, missing = _match(regions, surfaces, table.file)
        found += [*_no_parameters(table), *missing, *_curves(regions, curves, table.file)]
    refuse(found)
    return mesh, names


def _of_others(
    file: Path, table: FileMesh, regions: Regions, arrays_folder: Path
) -> tuple[SectionMeshTable, Names]:
    """Return the mesh of another program as arrays, and the description of each of its regions."""
    foreign = read_foreign(file, f'mesh.file = "{table.file}"', table.region_data)
    found = [*_no_parameters(table), *_curves(regions, foreign.curves, table.file)]
    refuse(found)
    names = [name for name in regions if name != ALL]
    region = assign_regions(foreign, names, ALL if ALL in regions else None)
    if (region == len(names)).any():
        names.append(ALL)
    arrays, digest = write_arrays(foreign, names, region, arrays_folder)
    return {"arrays": os.path.relpath(arrays), "sha256": digest}, {name: name for name in names}


def _no_parameters(table: FileMesh) -> list[str]:
    if table.parameters is None:
        return []
    return [f"mesh.parameters: expected with a .geo script only, not with {table.file}"]


def _direction(name: str, region: Region, stacks: Stacks) -> list[str]:
    """Return an error if it is missing: the layer direction of a wall in a user's mesh has no
    default."""
    plies = stacks.get(name, [])
    if region.direction is not None or not plies:
        return []
    if region.laminate is None and plies[0]["angle_deg"] == 0.0:
        return []
    what = f'laminate "{region.laminate}"' if region.laminate else f"angle {region.angle_deg:g} deg"
    return [
        f"regions.{name}.direction: missing, needed for the {what}: expected {{vector = [..]}}, "
        '{curve = ".."} or {circle = [..]}'
    ]


def _match(regions: Regions, surfaces: list[str], file: str) -> tuple[dict[str, str], list[str]]:
    """Return the description of each region of the mesh, and the errors."""
    found = [
        f"regions.{name}: {file} has no physical surface of this name{nearest(name, surfaces)}"
        for name in regions
        if name not in (*surfaces, ALL)
    ]
    names = {}
    for name in surfaces:
        described = name if name in regions else ALL
        if described in regions:
            names[name] = described
        else:
            found.append(
                f"regions.{name}: missing; {file} has the physical surfaces {few(surfaces)}"
            )
    return names, found


def _curves(regions: Regions, curves: Any, file: str) -> list[str]:
    """Return errors for curves of layer directions that the mesh does not have."""
    return [
        f'regions.{name}.direction.curve = "{region.direction.curve}": {file} has no curve of this '
        f"name{nearest(region.direction.curve, curves)}"
        for name, region in regions.items()
        if region.direction is not None
        and region.direction.curve is not None
        and region.direction.curve not in curves
    ]
