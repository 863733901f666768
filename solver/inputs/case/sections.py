"""The cross-section of a beam body: a shape of one material, or a described section."""

from pathlib import Path
from typing import Any

from ...errors import InputError
from ..common.material import plain
from ..section.description import Region
from ..section.expand import load_section, source_files
from ..section.shapes.library import walls
from ..section.shapes.mesh import ALL, shape_mesh
from .schema import BeamBody, DescribedSection, Mechanism


def section_spec(body: BeamBody, mechanism: Mechanism, folder: Path) -> dict[str, Any]:
    """Return the specification of a body's section, as of solver/inputs/section/expand.py.

    Parameters
    ----------
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        Lines that begin with the key: what is wrong with the section or does not fit the body.
    """
    key = f"sections.{body.section}"
    table = mechanism.sections[body.section]
    if isinstance(table, DescribedSection):
        try:
            spec = load_section(folder / table.file)
        except InputError as error:
            lines = [f"{key}.file: {line}" for line in str(error).splitlines()]
            raise InputError("\n".join(lines)) from error
        del spec["title"]  # another title is no other body
        return {**spec, "name": body.section}
    assert body.material is not None
    ply = {"material": body.material, "angle_deg": body.ply_angle_deg or 0.0}
    region = Region(material=body.material)
    mesh, regions = shape_mesh(table, {ALL: region}, {ALL: [ply]}, folder, where=key)
    if table.degree is not None:
        mesh["degree"] = table.degree
    return {
        "name": body.section,
        "convention": "contour",
        "mesh": mesh,
        "materials": {body.material: plain(mechanism.materials[body.material])},
        "regions": regions,
    }


def check_section(key: str, body: BeamBody, mechanism: Mechanism, folder: Path) -> list[str]:
    """Return what is wrong with a body's section; `key` names the body, its names exist."""
    table = mechanism.sections[body.section]
    given = {"material": body.material, "ply_angle_deg": body.ply_angle_deg}
    if isinstance(table, DescribedSection):
        found = [
            f"{key}.{name} = {value}: expected no such key, section {body.section} has its own "
            f"materials and angles ({table.file})"
            for name, value in given.items()
            if value is not None
        ]
    elif body.material is None:
        return [f"{key}.material: missing; expected the material of section {body.section}"]
    else:
        plane = all(w.direction == {"vector": [1.0, 0.0]} for w in walls(table.shape, table.values))
        found = []
        if body.ply_angle_deg and not plane:
            found.append(
                f"{key}.ply_angle_deg = {body.ply_angle_deg:g}: expected 0, a {table.shape} has "
                "walls in several directions: describe it in a file, sections.NAME.file"
            )
    try:
        section_spec(body, mechanism, folder)
    except InputError as error:
        found += str(error).splitlines()
    return found


def section_sources(mechanism: Mechanism, folder: Path) -> list[Path]:
    """Return the files beside the case file that its sections are made from."""
    tables = [t for t in mechanism.sections.values() if isinstance(t, DescribedSection)]
    return [path for table in tables for path in source_files(folder / table.file)]
