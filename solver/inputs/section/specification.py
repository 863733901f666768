"""From a section description to the specification that the FE side reads.

    {"name": "box", "title": "...", "convention": "contour",
     "mesh": {"script": "box", "parameters": {...}}           a script of meshes/
          or {"file": "blade.msh", "sha256": "...", ...}      gmsh's .msh or .geo
          or {"arrays": "blade-1f36fb5b0634.npz", ...}        see foreign.py
     "materials": {"cfrp": {"kind": "orthotropic", ...}},
     "regions": {"top": {"plies": [{"material": "cfrp", "angle_deg": 30.0, "thickness": 1e-4}],
                         "direction": {"vector": [1.0, 0.0]}}}}

Plain JSON, SI and degrees; paths are relative to the working directory. It contains only the
laminates and materials in use, so an unused laminate has no effect.
"""

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError, collected, nearest, refuse, unknown
from ...package.specification import PlyTable, SectionMeshTable, SectionRegionTable
from ..common.input_table import plain_table
from ..common.materials import check_materials, plain, unknown_materials
from ..common.mesh_files import (
    ALL,
    content_sha256,
    is_gmsh_mesh,
    matched,
    mesh_source,
    physical_names,
)
from ..common.text_file import read_toml
from .description import FileMesh, Region, SectionDescription, ShapeMesh, checked
from .foreign import assign_regions, read_foreign, write_arrays
from .shapes.contract import Values
from .shapes.library import Wall, expand, shape, walls
from .shapes.parts import few_across
from .vabs import is_of_another_code, spec_of_another_code

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
    errors: list[str] = []
    of_shape = walls(mesh.shape, values)
    names = [wall.region for wall in of_shape]
    for name in regions:
        if name not in (*names, ALL):
            errors.append(f"regions.{name}: a {mesh.shape} has no such wall{nearest(name, names)}")
    expanded: dict[str, SectionRegionTable] = {}
    for wall in of_shape:
        key = wall.region if wall.region in regions else ALL
        if key not in regions:
            errors.append(
                f"regions.{wall.region}: missing; a {mesh.shape} has the walls {', '.join(names)}"
            )
        elif key in stacks:
            errors += _fit(wall, key, stacks[key], mesh.values, values)
            given = regions[key].direction
            direction = wall.direction if given is None else plain_table(given)
            expanded[wall.region] = {"plies": stacks[key], "direction": {**direction}}
    refuse(errors)
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
    try:
        total = math.fsum(ply["thickness"] for ply in plies)
    except OverflowError:
        total = math.inf
    place = next((k for k in (wall.thickness, "wall", "skin") if k in given), wall.thickness)
    if place not in given and wall.region[-1].isdigit():
        sizes.setdefault(place, []).append(total)  # in the order of the walls
        return []
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
    errors = [line for name, region in regions.items() for line in _direction(name, region, stacks)]
    try:
        if file.suffix == ".geo" or (file.suffix == ".msh" and is_gmsh_mesh(file)):
            mesh, names = _of_gmsh(file, table, regions)
        else:
            mesh, names = _of_others(file, table, regions, arrays_folder)
    except InputError as error:
        raise InputError("\n".join([*str(error).splitlines(), *errors])) from error
    refuse(errors)
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
    errors = []
    if table.region_data is not None:
        errors.append(
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
        names, missing = matched(regions, surfaces, table.file)
        errors += [*_no_parameters(table), *missing, *_curves(regions, curves, table.file)]
    refuse(errors)
    return mesh, names


def _of_others(
    file: Path, table: FileMesh, regions: Regions, arrays_folder: Path
) -> tuple[SectionMeshTable, Names]:
    """Return the mesh of another program as arrays, and the description of each of its regions."""
    foreign = read_foreign(file, f'mesh.file = "{table.file}"', table.region_data)
    errors = [*_no_parameters(table), *_curves(regions, foreign.curves, table.file)]
    refuse(errors)
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


BUILD = Path("build/sections")  # default folder of arrays


def load_section(file: Path, folder: Path = BUILD) -> dict[str, object]:
    """Return the specification of a described section.

    Parameters
    ----------
    file : the description
    folder : where a mesh that meshio reads is written as arrays

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    if is_of_another_code(file):
        return spec_of_another_code(file, folder)
    return section_spec(read_toml(file, "section description"), file, folder)


def source_files(table: Mapping[str, Any], file: Path) -> list[Path]:
    """Return the source files of a section: its description, and its mesh or contour file.

    Parameters
    ----------
    table : a valid description, see `section_spec`
    file : file of the description
    """
    mesh = table["mesh"]
    beside = [file.parent / mesh[key] for key in ("file", "contour") if key in mesh]
    return [file, *(path for path in beside if path.is_file())]


def section_spec(table: Mapping[str, Any], file: Path, folder: Path = BUILD) -> dict[str, object]:
    """Return the specification of a description already read; see `load_section`.

    Parameters
    ----------
    table : the description; its file names are relative to the folder of `file`
    file : file of the description, for messages and for the section's name
    """
    description = checked(table, file)
    problems = check_materials(description.materials)
    stacks: dict[str, list[PlyTable]] = {}
    for name, region in description.regions.items():
        with collected(problems):
            stacks[name] = _stack(name, region, description)
    problems += _convention(description, stacks)
    mesh: SectionMeshTable = {}
    regions: dict[str, SectionRegionTable] = {}
    with collected(problems):
        if isinstance(description.mesh, ShapeMesh):
            mesh, regions = shape_mesh(
                description.mesh,
                description.regions,
                stacks,
                file.parent,
                curved=description.initial_curvature is not None,
            )
        else:
            mesh, regions = file_mesh(description, stacks, file.parent, folder)
    refuse(f"{file}: {problem}" for problem in problems)
    if description.mesh.degree is not None:
        mesh["degree"] = description.mesh.degree
    used = {ply["material"] for region in regions.values() for ply in region["plies"]}
    return {
        "name": file.stem,
        "title": description.title,
        **_along(description),
        "convention": description.convention or "contour",  # no angle: the same beam
        "mesh": mesh,
        "materials": {n: plain(m) for n, m in description.materials.items() if n in used},
        "regions": regions,
    }


def _along(description: SectionDescription) -> dict[str, object]:
    """Return the keys that are not about the plane of the section."""
    keys: dict[str, object] = {}
    if description.allow:
        keys["allow"] = list(description.allow)
    if description.initial_curvature is not None:
        keys["initial_curvature"] = list(description.initial_curvature)
    if description.taper:
        keys["taper"] = description.taper
    return keys


def _stack(name: str, region: Region, description: SectionDescription) -> list[PlyTable]:
    """Return the plies of a region, outermost first."""
    plies: list[PlyTable]
    if region.material is not None:
        plies = [{"material": region.material, "angle_deg": region.angle_deg or 0.0}]
        key = f"regions.{name}.material"
    else:
        key, laminate = f"laminates.{region.laminate}", str(region.laminate)
        laminates = description.laminates
        if errors := unknown(f"regions.{name}.laminate", laminate, "laminate", laminates):
            raise InputError(errors[0])
        plies = laminates[laminate].stack()
    if errors := unknown_materials(key, (p["material"] for p in plies), description.materials):
        raise InputError("\n".join(errors))
    return plies


def _convention(description: SectionDescription, stacks: Stacks) -> list[str]:
    """Return an error if `convention` is missing: the sense of ply angles has no default."""
    if description.convention is not None:
        return []
    for name, plies in stacks.items():
        angles = [ply["angle_deg"] for ply in plies if ply["angle_deg"] != 0.0]
        if angles:
            return [
                f'convention: missing; expected "contour" or "cartesian": regions.{name} has a ply '
                f"at {angles[0]:g} deg"
            ]
    return []
