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

from pathlib import Path
from typing import Any

from ...errors import InputError, collected, refuse, unknown
from ...package.specification import PlyTable, SectionMeshTable, SectionRegionTable
from ..common import read_toml
from ..common.lay_up import unknown_materials
from ..common.material import check_materials, plain
from .codes.other_codes import is_of_another_code, spec_of_another_code
from .description import Region, SectionDescription, checked
from .mesh_file import file_mesh
from .mesh_table import ShapeMesh
from .shape_mesh import Stacks, shape_mesh

BUILD = Path("build/sections")  # default folder of arrays


def load_section(file: Path, folder: Path = BUILD) -> dict[str, Any]:
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


def source_files(table: dict[str, Any], file: Path) -> list[Path]:
    """Return the source files of a section: its description, and its mesh or contour file.

    Parameters
    ----------
    table : a valid description, see `section_spec`
    file : file of the description
    """
    mesh = table["mesh"]
    beside = [file.parent / mesh[key] for key in ("file", "contour") if key in mesh]
    return [file, *(path for path in beside if path.is_file())]


def section_spec(table: dict[str, Any], file: Path, folder: Path = BUILD) -> dict[str, Any]:
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


def _along(description: SectionDescription) -> dict[str, Any]:
    """Return the keys that are not about the plane of the section."""
    keys: dict[str, Any] = {}
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
        if found := unknown(f"regions.{name}.laminate", laminate, "laminate", laminates):
            raise InputError(found[0])
        plies = laminates[laminate].stack()
    if found := unknown_materials(key, (p["material"] for p in plies), description.materials):
        raise InputError("\n".join(found))
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
