"""The cross-section of a beam body: a shape of one material, or a described section."""

from pathlib import Path
from typing import Any

from ...errors import InputError, under
from ..common.material import plain
from ..section.description import Region
from ..section.expand import section_spec as described_section
from ..section.expand import source_files
from ..section.shapes.library import walls
from ..section.shapes.mesh import ALL, shape_mesh
from .beam_schema import BeamBody, BeamStation
from .descriptions import INLINE, section_table
from .schema import Mechanism
from .section_schema import DescribedSection


def section_spec(
    body: BeamBody, mechanism: Mechanism, folder: Path
) -> tuple[dict[str, Any], list[Path]]:
    """Return the specification of a body's section, and the files that it is made from.

    Parameters
    ----------
    body : has passed `check_section`
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        Lines that begin with the key: what is wrong with the section.
    """
    assert body.section is not None
    key = f"sections.{body.section}"
    table = mechanism.sections[body.section]
    if isinstance(table, DescribedSection):
        return _described(key, body.section, table, mechanism, folder)
    assert body.material is not None
    ply = {"material": body.material, "angle_deg": body.ply_angle_deg or 0.0}
    region = Region(material=body.material)
    mesh, regions = shape_mesh(table, {ALL: region}, {ALL: [ply]}, folder, where=key)
    if table.degree is not None:
        mesh["degree"] = table.degree
    spec = {
        "name": body.section,
        "convention": "contour",
        "mesh": mesh,
        "materials": {body.material: plain(mechanism.materials[body.material])},
        "regions": regions,
    }
    return spec, []


def given_section(station: BeamStation) -> dict[str, Any]:
    """Return the specification of a station with matrices of its own."""
    return {
        "name": f"at {station.at:.4f}",
        "stiffness": station.stiffness,
        "mass": station.mass,
        "trapeze": station.trapeze,
    }


def check_section(key: str, body: BeamBody, mechanism: Mechanism) -> list[str]:
    """Return what does not fit between a body and its section; `key` names the body."""
    assert body.section is not None
    table = mechanism.sections[body.section]
    given = {"material": body.material, "ply_angle_deg": body.ply_angle_deg}
    if isinstance(table, DescribedSection):
        return [
            f"{key}.{name} = {value}: expected no such key, section {body.section} has its own "
            f"materials and angles ({table.file or INLINE})"
            for name, value in given.items()
            if value is not None
        ]
    if body.material is None:
        return [f"{key}.material: missing; expected the material of section {body.section}"]
    plane = all(w.direction == {"vector": [1.0, 0.0]} for w in walls(table.shape, table.values))
    if body.ply_angle_deg and not plane:
        return [
            f"{key}.ply_angle_deg = {body.ply_angle_deg:g}: expected 0, a {table.shape} has "
            "walls in several directions: describe it in a file, sections.NAME.file"
        ]
    return []


def _described(
    key: str, name: str, section: DescribedSection, mechanism: Mechanism, folder: Path
) -> tuple[dict[str, Any], list[Path]]:
    file = folder / INLINE
    try:
        table, file = section_table(name, section, mechanism, folder)
        spec = described_section(table, file)
    except InputError as error:
        if section.file is not None:
            raise under(f"{key}.file", error) from error
        bare = (line.removeprefix(f"{file}: ") for line in str(error).splitlines())
        raise InputError("\n".join(f"{key}.{INLINE}.{line}" for line in bare)) from error
    del spec["title"]  # another title is no other body
    return {**spec, "name": name}, source_files(table, file)[section.file is None :]
