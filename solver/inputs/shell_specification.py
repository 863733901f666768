"""From a shell description to the specification that the FE side reads."""

import os
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, collected, nearest, refuse, under, unknown
from .common.input_table import plain_table
from .common.materials import check_materials, plain, unknown_materials
from .common.mesh_files import SUFFIXES as SCRIPTS
from .common.mesh_files import (
    content_sha256,
    is_gmsh_mesh,
    library,
    matched,
    mesh_source,
    physical_groups,
)
from .common.text_file import read_toml
from .section.foreign import gmsh_mesh
from .shell import Mesh, Region, ShellDescription, checked

BUILD = Path("build/shells")  # folder of meshes of other programs, written as those of gmsh

# From a shell description to the specification that the FE side reads.
#
#     {"name": "panel", "title": "...",
#      "mesh": {"file": "panel.geo", "sha256": "...", "parameters": {...}, "scale": 1e-3},
#      "materials": {"cfrp": {"kind": "orthotropic", ...}},
#      "laminates": {"skin": {"plies": [{"material": "cfrp", "angle_deg": 45.0, "thickness": 1e-4}],
#                             "offset": "mid", "shear_correction": "energy-1d"}},
#      "regions": {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0], "flip": false}},
#      "elements": {...}, "stiffeners": {...}, "links": {...},
#      "supports": {"root": {"at": "root", "fixed": ["ux", "uy", "uz", "rx", "ry", "rz"]}},
#      "loads": {"pull": {"tip": {"at": "tip", "force": [1.0, 0.0, 0.0]}}},
#      "probes": {...}, "frequencies": {"count": 6, "free": false, "error": false},
#      "buckling": {"count": 4, "in_plane": true, "error": true}}
#
# Plain JSON, SI and degrees; paths are relative to the working directory, plies one by one from
# bottom to top. Materials and laminates that no region uses are omitted.


def load_shell(file: Path, buckling: int | None = None, bound: str | None = None) -> dict[str, Any]:
    """Return the specification of a described shell.

    Parameters
    ----------
    buckling : number of load factors of each load case, in place of that of the description
    bound : quantity that is bounded over all lay-ups, in place of that of the description

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    table = read_toml(file, "shell description")
    spec = shell_spec(table if bound is None else {**table, "bound": bound}, file)
    if buckling is None:
        return spec
    if not spec["loads"]:
        raise InputError(f"{file}: --buckling needs a load case, [loads.CASE.NAME]")
    usual = {"in_plane": True, "error": True}
    return {**spec, "buckling": {**usual, **spec.get("buckling", {}), "count": buckling}}


def shell_spec(table: Mapping[str, Any], file: Path) -> dict[str, Any]:
    """Return the specification of a description already read; see `load_shell`.

    Parameters
    ----------
    table : the description; its file names are relative to the folder of `file`
    file : file of the description, for messages and for the shell's name
    """
    description = checked(table, file)
    problems = [
        *check_materials(description.materials),
        *_references(description),
        *_loads_on_links(description),
    ]
    mesh: dict[str, object] = {}
    with collected(problems):
        mesh = _mesh(description.mesh, file.parent, description.regions)
        if description.mesh.file is not None:
            problems += _groups(description, file.parent / description.mesh.file)
    stiffeners: dict[str, object] = {}
    with collected(problems):
        stiffeners = _stiffeners(description, file.parent)
    refuse(f"{file}: {problem}" for problem in problems)
    laminates, regions = _regions(description)
    used = {ply["material"] for laminate in laminates.values() for ply in laminate["plies"]}
    asked = {"elements", "links", "loads", "probes", "frequencies", "buckling"}
    asked |= {"bound", "bound_angles_deg"}
    spec = {
        "name": file.stem,
        "title": description.title,
        "mesh": mesh,
        "materials": {n: plain(m) for n, m in description.materials.items() if n in used},
        "laminates": laminates,
        "regions": regions,
        **description.model_dump(include=asked, exclude_none=True),
        "supports": {
            name: {
                "at": support.at,
                "fixed": support.freedoms,
                **({"only": support.only} if support.only else {}),
            }
            for name, support in description.supports.items()
        },
    }
    if description.allow:
        spec["allow"] = list(description.allow)
    if stiffeners:
        spec["stiffeners"] = stiffeners
    if "prestress" in spec.get("frequencies", {}):
        spec["frequencies"] = {"error": True, **spec["frequencies"]}
    return spec


def _stiffeners(description: ShellDescription, folder: Path) -> dict[str, Any]:
    """Stiffeners with the specifications of their sections."""
    stiffeners = {n: plain_table(each) for n, each in description.stiffeners.items()}
    for name, table in stiffeners.items():
        if "section" not in table:
            continue
        from .section.specification import load_section  # here: few shells have stiffeners

        try:
            section = load_section(folder / table["section"])
        except InputError as error:
            raise under(f"stiffeners.{name}.section", error) from error
        del section["title"]
        table["section"] = section
    return stiffeners


def _mesh(table: Mesh, folder: Path, regions: Collection[str]) -> dict[str, object]:
    if table.file is None:
        file, key = library("shells") / f"{table.shape}.py", f'mesh.shape = "{table.shape}"'
    else:
        file, key = mesh_source(table.file, folder)
    if table.parameters is not None and file.suffix not in SCRIPTS:
        raise InputError(f"mesh.parameters: expected with a script only, not with {table.file}")
    if file.suffix == ".msh" and not is_gmsh_mesh(file):
        raise InputError(f"{key}: not a mesh of gmsh")
    if file.suffix not in (".msh", *SCRIPTS):
        file = gmsh_mesh(file, key, BUILD, 2, regions)
    options = table.model_dump(exclude={"file", "shape"}, exclude_defaults=True)
    return {"file": os.path.relpath(file), "sha256": content_sha256(file), **options}


def _regions(description: ShellDescription) -> tuple[dict[str, Any], dict[str, Any]]:
    """Laminates in use, and the regions with the names of their laminates."""
    laminates: dict[str, object] = {}
    regions: dict[str, object] = {}
    for name, region in description.regions.items():
        laminate = region.laminate
        if laminate is not None:
            own = description.laminates[laminate]
            laminates[laminate] = {
                "plies": own.stack(),
                "offset": own.offset,
                "shear_correction": own.shear_correction,
            }
        else:
            laminate = f"{name}: {region.material}"
            ply = {"material": region.material, "angle_deg": 0.0, "thickness": region.thickness}
            laminates[laminate] = {
                "plies": [ply],
                "offset": "mid" if region.offset is None else region.offset,
                "shear_correction": "energy-1d",
            }
        axes = region.model_dump(include={"axis", "axis_curve", "axis_about"}, exclude_none=True)
        regions[name] = {"laminate": laminate, **axes, "flip": region.flip}
    return laminates, regions


def _references(description: ShellDescription) -> list[str]:
    """Laminates and materials that are named but not described."""
    errors = []
    for name, region in description.regions.items():
        key = f"regions.{name}"
        if region.laminate is not None:
            errors += unknown(f"{key}.laminate", region.laminate, "laminate", description.laminates)
        if region.material is not None:
            errors += unknown(key, region.material, "material", description.materials)
        errors += _directed(name, region, description)
    for name, laminate in description.laminates.items():
        materials = [ply["material"] for ply in laminate.stack()]
        errors += unknown_materials(f"laminates.{name}", materials, description.materials)
    return errors


def _directed(name: str, region: Region, description: ShellDescription) -> list[str]:
    """Errors for missing reference directions: an orthotropic ply needs one."""
    if (region.axis, region.axis_curve, region.axis_about) != (None, None, None):
        return []
    laminate = description.laminates.get(region.laminate or "")
    names = [ply["material"] for ply in laminate.stack()] if laminate else [region.material]
    kinds = [description.materials[n].kind for n in names if n in description.materials]
    if "orthotropic" not in kinds:
        return []
    return [
        f"regions.{name}.axis: missing, needed for the direction of its plies: expected "
        'axis = [x, y, z], axis_curve = ".." or axis_about = {point = [..], direction = [..]}'
    ]


def _groups(description: ShellDescription, file: Path) -> list[str]:
    """Errors for names that a .msh file does not have; only gmsh knows the names in a script."""
    if file.suffix != ".msh":
        return []
    points, curves, surfaces = physical_groups(file)
    if not surfaces:
        return [
            f'mesh.file = "{description.mesh.file}": no physical surface of it has a name, '
            'expected one per region, such as Physical Surface("skin") = {1};'
        ]
    _, errors = matched(description.regions, surfaces, file.name)
    known = [*points, *curves, *surfaces]
    for key, name in _places(description):
        links = () if key.startswith("links.") else description.links
        if name not in known and name not in links:
            errors.append(
                f'{key} = "{name}": {file.name} has no physical group of this name'
                f"{nearest(name, (*known, *links))}"
            )
    for name, region in description.regions.items():
        if region.axis_curve is not None and region.axis_curve not in curves:
            errors.append(
                f'regions.{name}.axis_curve = "{region.axis_curve}": {file.name} has no physical '
                f"curve of this name{nearest(region.axis_curve, curves)}"
            )
    return errors


def _places(description: ShellDescription) -> list[tuple[str, str]]:
    """Key and name of every group in the description."""
    tables: list[tuple[str, Any]] = [
        *((f"stiffeners.{name}", rib) for name, rib in description.stiffeners.items()),
        *((f"links.{name}", link) for name, link in description.links.items()),
        *((f"supports.{name}", support) for name, support in description.supports.items()),
        *(
            (f"loads.{case}.{name}", load)
            for case, loads in description.loads.items()
            for name, load in loads.items()
        ),
        *((f"probes.{name}", probe) for name, probe in description.probes.items()),
    ]
    return [
        (f"{key}.at", name)
        for key, table in tables
        if table.at is not None
        for name in ([table.at] if isinstance(table.at, str) else table.at)
    ]


def _loads_on_links(description: ShellDescription) -> list[str]:
    """Errors for distributed loads on a reference point: it has no length and no area."""
    return [
        f'loads.{case}.{name}.at = "{load.at}": a link takes `force`, `moment` or `motion` only'
        for case, loads in description.loads.items()
        for name, load in loads.items()
        if load.at in description.links and not (load.force or load.moment or load.motion)
    ]
