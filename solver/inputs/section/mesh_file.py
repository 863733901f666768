"""Sections on a user's mesh: gmsh's files are passed on, others are converted to arrays."""

import hashlib
import io
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, few, nearest
from ...math.arrays import IntArray
from ...package.common.temporary import temporary_sibling
from ..common.gmsh_file import content_sha256, is_gmsh_mesh, physical_names
from ..scripts import refuse_script
from .description import Region, SectionDescription
from .foreign import ForeignMesh, read_foreign
from .mesh_table import FileMesh
from .shapes.mesh import ALL, Stacks

# A foreign mesh as plain arrays for the preprocessor, each cell in one described region.
#
# An .npz file with
#
#     points        (n, 2)  x2, x3, in the unit of the source
#     cells         (c, k)  rows of points, in gmsh's order of nodes
#     cell_type     "triangle", "triangle6", "quad" or "quad9"
#     region        (c,)    row of region_names
#     region_names  (r,)    text
#     lines         (m, 2 or 3)  line cells of the named curves: ends, then the middle
#     curve         (m,)    row of curve_names
#     curve_names   (s,)    text


def assign_regions(mesh: ForeignMesh, names: Iterable[str], default: str | None) -> IntArray:
    """Return the region of every cell as a row of `names`, (c,); `default` comes after the last.

    Parameters
    ----------
    names : described regions, names of sets of the mesh
    default : name of the region of all other cells; None: there must be no other cell

    Raises
    ------
    InputError
        A name that the mesh does not have, cells in two regions or in none.
    """
    names = list(names)
    found = []
    region = np.full(len(mesh.cells), -1, dtype=np.int64)
    for row, name in enumerate(names):
        if name not in mesh.sets:
            found.append(
                f"regions.{name}: {mesh.file.name} has no such region{nearest(name, mesh.sets)}"
            )
            continue
        for other in np.unique(region[mesh.sets[name] & (region >= 0)]):
            both = int(np.count_nonzero(mesh.sets[name] & (region == other)))
            found.append(
                f"regions.{name}: {both} of its cells in {mesh.file.name} are in region "
                f"{names[other]} too: expected each cell in one region"
            )
        region[mesh.sets[name]] = row
    bare = region < 0
    if default is None and bare.any() and not found:
        left = [name for name, mask in mesh.sets.items() if (mask & bare).any()]
        listed = f"; they are in {few(left)}" if left else ""
        found.append(
            f"regions: {np.count_nonzero(bare)} of {bare.size} cells of {mesh.file.name} belong to "
            f"no described region{listed}: expected a table for each, or regions.all"
        )
    if found:
        raise InputError("\n".join(found))
    region[bare] = len(names)
    return region


def write_arrays(
    mesh: ForeignMesh, names: Iterable[str], region: IntArray, folder: Path
) -> tuple[Path, str]:
    """Write the arrays beside the specification; return the file and its SHA-256.

    The name contains the hash, so that equal content is written once.
    """
    rows, curve = np.nonzero(
        np.array(list(mesh.curves.values()), dtype=bool).T.reshape(
            len(mesh.lines), len(mesh.curves)
        )
    )
    return write_npz(
        folder,
        mesh.file.stem,
        points=mesh.points,
        cells=mesh.cells,
        cell_type=np.array(mesh.cell_type),
        region=region,
        region_names=np.array(list(names), dtype=str),
        lines=mesh.lines[rows],
        curve=curve,
        curve_names=np.array(list(mesh.curves), dtype=str),
    )


def write_npz(folder: Path, name: str, **arrays: Any) -> tuple[Path, str]:
    """Write named arrays to a file whose name ends in its hash; return file and SHA-256."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    content = buffer.getvalue()
    digest = hashlib.sha256(content).hexdigest()
    file = folder / f"{name}-{digest[:12]}.npz"
    if not file.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(file) as temporary:
            temporary.write_bytes(content)
    return file, digest


# Sections on a user's mesh: gmsh's files are passed on, others are converted to arrays.

Regions = dict[str, Region]
Names = dict[str, str]  # region of the mesh -> its description


def file_mesh(
    description: SectionDescription, stacks: Stacks, folder: Path, arrays_folder: Path
) -> tuple[dict[str, Any], dict[str, Any]]:
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
    file = folder / table.file
    refuse_script(file, f'mesh.file = "{table.file}"')
    if not file.is_file():
        raise InputError(f'mesh.file = "{table.file}": there is no file {file}')
    found = [line for name, region in regions.items() for line in _direction(name, region, stacks)]
    try:
        if file.suffix == ".geo" or (file.suffix == ".msh" and is_gmsh_mesh(file)):
            mesh, names = _of_gmsh(file, table, regions)
        else:
            mesh, names = _of_others(file, table, regions, arrays_folder)
    except InputError as error:
        raise InputError("\n".join([*str(error).splitlines(), *found])) from error
    if found:
        raise InputError("\n".join(found))
    if table.scale is not None:
        mesh["scale"] = table.scale
    expanded: dict[str, Any] = {}
    for name, described in names.items():
        if described in stacks:
            expanded[name] = {"plies": stacks[described]}
            direction = regions[described].direction
            if direction is not None:
                expanded[name]["direction"] = direction.model_dump(exclude_none=True)
    return mesh, expanded


def _of_gmsh(file: Path, table: FileMesh, regions: Regions) -> tuple[dict[str, Any], Names]:
    """Return a mesh or script of gmsh, and the description of each of its regions."""
    script = file.suffix == ".geo"
    found = []
    if table.region_data is not None:
        found.append(
            f'mesh.region_data = "{table.region_data}": expected no such key, the regions of '
            f"{table.file} are its physical surfaces"
        )
    mesh: dict[str, Any] = {"file": os.path.relpath(file), "sha256": content_sha256(file)}
    if script:
        if table.parameters is not None:
            mesh["parameters"] = table.parameters
        names = {name: name for name in regions}  # `all`: gmsh will know the others
    else:
        surfaces, curves = physical_names(file, f'mesh.file = "{table.file}"')
        names, missing = _match(regions, surfaces, table.file)
        found += [*_no_parameters(table), *missing, *_curves(regions, curves, table.file)]
    if found:
        raise InputError("\n".join(found))
    return mesh, names


def _of_others(
    file: Path, table: FileMesh, regions: Regions, arrays_folder: Path
) -> tuple[dict[str, Any], Names]:
    """Return the mesh of another program as arrays, and the description of each of its regions."""
    foreign = read_foreign(file, f'mesh.file = "{table.file}"', table.region_data)
    found = [*_no_parameters(table), *_curves(regions, foreign.curves, table.file)]
    if found:
        raise InputError("\n".join(found))
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
