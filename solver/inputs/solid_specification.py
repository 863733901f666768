"""From a solid description, or a CAD file alone, to the specification that the FE side reads.

Meshes of other programs, such as MED, are read by meshio and written as meshes of gmsh.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, collected, did_you_mean, refuse, unknown
from ..package.specification import CAD, CAD_WITH_UNIT, SolidSpecification, SolidTable
from .common.input_table import plain_table, validated
from .common.materials import check_materials, plain
from .common.mesh_files import content_sha256, is_gmsh_mesh, mesh_source
from .common.published_materials import LIBRARY
from .common.text_file import read_toml
from .common.units import LENGTHS, UNITS, file_units
from .section.foreign import gmsh_mesh
from .solid import SolidDescription

BUILD = Path("build/solids")  # folder of such meshes

AXES = ("axis", "axis_along", "axis_about", "normal")
DIRECTED = (["axis", "normal"], ["axis_along", "normal"], ["axis_about"])
# Metals by their usual constants; strengths differ from alloy to alloy and are not among them.
METALS = {
    "aluminium": (70e9, 0.33, 2700.0),
    "steel": (210e9, 0.3, 7850.0),
    "titanium": (114e9, 0.34, 4430.0),
}


def solid_table(
    table: Mapping[str, Any], file: Path, size: float | None = None
) -> tuple[SolidDescription, SolidTable]:
    """Return a description, and geometry and materials of its specification.

    Parameters
    ----------
    table : the description as it was read
    file : for messages and relative paths
    size : of the cells in place of the given one [m]

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    units = file_units(table)
    if size is not None and isinstance(table.get("mesh"), dict):
        size = size / LENGTHS[units.get(UNITS, "m")]  # as in the file
        table = {**table, "mesh": {**table["mesh"], "size": size}}
    description = validated(SolidDescription, table, file, **units)
    problems = [*check_materials(description.materials), *_references(description)]
    mesh: dict[str, object] = {}
    with collected(problems):
        mesh = _mesh(description, file.parent)
    refuse(f"{file}: {problem}" for problem in problems)
    used = {region.material for region in description.regions.values()}
    return description, {
        "mesh": mesh,  # type: ignore[typeddict-item]
        "materials": {n: plain(m) for n, m in description.materials.items() if n in used},
        "regions": {name: plain_table(region) for name, region in description.regions.items()},
        "allow": list(description.allow),
    }


def solid_spec(file: Path, material: str | None, size: float | None) -> SolidSpecification:
    """Return the specification of `plymotion solid` for a description or a CAD file.

    Parameters
    ----------
    material : of a CAD file: a name of METALS or of the library, or "E,nu,rho" in SI
    size : of the cells [m], in place of that of the description

    Raises
    ------
    InputError
        See `solid_table`; a CAD file without a material.
    """
    if not file.exists():
        raise InputError(f"{file}: no such file")
    if file.suffix.lower() in CAD:
        table: dict[str, object] = {
            "mesh": {"file": file.name},
            "materials": {"material": _material(file, material)},
            "regions": {"all": {"material": "material"}},
        }
    else:
        if file.suffix.lower() != ".toml":
            raise InputError(f"{file}: expected a STEP or IGES file, or a description (.toml)")
        if material is not None:
            raise InputError(f"{file}: --material: expected with a CAD file only")
        table = read_toml(file, "solid description")
    description, solid = solid_table(table, file, size)
    return {
        "body": file.stem,
        "kind": "solid",
        "title": description.title,
        "solid": solid,
        "reference": {"kind": "mean-axis"},
        "modes": [{"kind": "lowest", "count": description.frequencies.count}],
        "damping_ratio": 0.0,
        "interfaces": {n: plain_table(each) for n, each in description.interfaces.items()},
        "analysis": {
            "supports": description.supports,
            "loads": {
                case: {name: plain_table(load) for name, load in loads.items()}
                for case, loads in description.loads.items()
            },
            "error": description.frequencies.error,
        },
    }


def _material(file: Path, text: str | None) -> dict[str, object]:
    isotropic = {n: m.table for n, m in LIBRARY.items() if m.table["kind"] == "isotropic"}
    if text in isotropic:
        return isotropic[text]
    expected = (
        f"expected {', '.join((*METALS, *isotropic))} or E,nu,rho in Pa and kg/m3, such as "
        "70e9,0.33,2700"
    )
    if text is None:
        raise InputError(f"{file}: --material: missing; {expected}")
    try:
        values = METALS[text] if text in METALS else tuple(map(float, text.split(",")))
    except ValueError:
        values = ()
    if len(values) != 3:
        hint = did_you_mean(text, (*METALS, *isotropic))
        raise InputError(f"{file}: --material {text}: {expected}{hint}")
    return {"kind": "isotropic", **dict(zip(("E", "nu", "rho"), values, strict=True))}


def _mesh(description: SolidDescription, folder: Path) -> dict[str, object]:
    table = description.mesh
    file, key = mesh_source(table.file, folder)
    if file.suffix == ".msh" and not is_gmsh_mesh(file):
        raise InputError(f"{key}: not a mesh of gmsh")
    if file.suffix.lower() not in (*CAD, ".geo", ".msh"):
        key += f": expected {', '.join(CAD)}, .geo, .msh or another mesh"
        file = gmsh_mesh(file, key, BUILD, 3, description.regions)
    own_unit = file.suffix.lower() in CAD_WITH_UNIT
    if not own_unit and table.unit is None and description.units != "m":
        table = table.model_copy(update={"unit": description.units})
    if own_unit and table.unit is not None:
        raise InputError(f'mesh.unit = "{table.unit}": expected none: {table.file} has its own')
    if not own_unit and table.unit is None:
        raise InputError(
            f"mesh.unit: missing: {table.file} has no unit of length; expected one of "
            f"{', '.join(LENGTHS)}"
        )
    for name in ("size", "accuracy"):
        if getattr(table, name) is not None and file.suffix.lower() not in CAD:
            raise InputError(f"mesh.{name}: expected with a CAD file only, not with {table.file}")
    if table.parameters is not None and file.suffix != ".geo":
        raise InputError(f"mesh.parameters: expected with a .geo script, not with {table.file}")
    mesh = plain_table(table) | {"file": os.path.relpath(file), "sha256": content_sha256(file)}
    if table.unit is not None:
        mesh["unit"] = LENGTHS[table.unit]
    return dict(mesh)


def _references(description: SolidDescription) -> list[str]:
    """Return errors of materials and interfaces that are named but not described."""
    errors = []
    for name, region in description.regions.items():
        key = f"regions.{name}.material"
        errors += unknown(key, region.material, "material", description.materials)
        material = description.materials.get(region.material)
        given = [key for key in AXES if getattr(region, key) is not None]
        if material and material.kind == "orthotropic" and given not in DIRECTED:
            errors.append(
                f"regions.{name}.axis: missing, needed for the directions of an orthotropic "
                "material: expected axis and normal, axis_along and normal, or axis_about alone; "
                f"found {' and '.join(given) or 'none'}"
            )
    places = [("supports", name) for name in description.supports]
    places += [
        (f"loads.{case}.{name}.at", load.at)
        for case, loads in description.loads.items()
        for name, load in loads.items()
        if load.at is not None
    ]
    for key, place in places:
        errors += unknown(key, place, "interface", description.interfaces)
        interface = description.interfaces.get(place)
        if interface is not None and key == "supports" and interface.link != "rigid":
            errors.append(f'interfaces.{place}.link = "average": expected "rigid": it is held')
    if description.loads and not description.supports:
        errors.append("supports: missing; expected an interface that holds the solid, with [loads]")
    return errors
