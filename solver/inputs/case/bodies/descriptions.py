"""Sections, shells and solids of a case that a description defines."""

import os
from pathlib import Path
from typing import Any, cast

from pydantic import BaseModel

from ....errors import InputError, few, refuse, under
from ....package.specification import ShellSpecification, SolidSpecification
from ...common.input_table import plain_table
from ...common.mesh_files import physical_groups
from ...common.text_file import read_toml
from ...section.description import checked as checked_section
from ...section.study import changed
from ...shell import checked as checked_shell
from ...shell_specification import shell_spec
from ...solid_specification import solid_table
from ..tables.beam_keys import BeamBody
from ..tables.bodies import (
    AttachmentChoice,
    DescribedSection,
    ModeChoice,
    Modes,
    ShellBody,
    SolidBody,
    SpinningChoice,
    check_places,
)
from ..tables.schema import Mechanism

INLINE = "description"


def section_table(
    name: str, section: DescribedSection, mechanism: Mechanism, folder: Path
) -> tuple[dict[str, object], Path]:
    """Return the description of a section, and its file; of one in the case, a name beside it.

    Parameters
    ----------
    name : name of the section
    section : its table in the case
    mechanism : tables of the case, checked for types and bounds
    folder : folder for relative names of files

    Raises
    ------
    InputError
        No such file; a change of a key that does not exist.
    """
    if section.file is not None:
        file = folder / section.file
        table = read_toml(file, "section description")
    else:
        file = folder / INLINE
        known = {name: plain_table(each) for name, each in mechanism.materials.items()}
        table = {"format": 1, "title": name, **(section.description or {})}
        own = table.get("materials", {})
        table["materials"] = {**known, **own} if isinstance(own, dict) else own
    return changed(table, section.changes, file), file


def shell_table(body: ShellBody, folder: Path) -> tuple[dict[str, object], Path]:
    """Return the description of a shell, and its file.

    Raises
    ------
    InputError
        No such file; a change of a key that does not exist.
    """
    file = folder / body.shell
    return changed(read_toml(file, "shell description"), body.changes, file), file


def described(way: list[str], mechanism: Mechanism, folder: Path) -> BaseModel | None:
    """Return the model of the description that the table at `way` has, None without one.

    Parameters
    ----------
    way : keys from the case to the table
    mechanism : tables of the case, checked for types and bounds
    folder : folder for relative names of files

    Raises
    ------
    InputError
        A description that is wrong.
    """
    group, name, *more = way
    if more or group not in ("sections", "bodies"):
        return None
    owner: Any = getattr(mechanism, group).get(name)
    if getattr(owner, "changes", None) is None:
        return None
    if group == "sections":
        return checked_section(*section_table(name, owner, mechanism, folder))
    table, file = shell_table(owner, folder)
    return checked_shell({**table, "frequencies": table.get("frequencies", {})}, file)


# Keys of a description for its own analysis; the mechanism supports and loads a body.
OF_SHELLS = ("links", "supports", "loads", "probes", "frequencies")
OF_SOLIDS = ("supports", "loads", "interfaces")


def reduction(body: BeamBody | ShellBody | SolidBody) -> dict[str, object]:
    """Return how a body is reduced, as in its specification."""
    second = {"second_order": True} if getattr(body, "second_order", False) else {}
    return {
        "reference": plain_table(body.reference),
        "modes": [plain_table(mode) for mode in body.modes],
        "damping_ratio": body.damping_ratio,
        "interfaces": {k: plain_table(v) for k, v in body.interfaces.items()},
        **second,
    }


def shell_body_spec(
    name: str, body: ShellBody, folder: Path
) -> tuple[ShellSpecification, list[Path]]:
    """Return the specification of a shell, and the files beside the case file it is made from.

    Parameters
    ----------
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        What is wrong with the body, one line each.
    """
    key = f"bodies.{name}"
    try:
        shell = _shell(body, folder)
    except InputError as error:
        raise under(f"{key}.shell", error) from error
    mesh = Path(shell["mesh"]["file"])
    errors = _groups(key, body, mesh) + check_places(key, body)
    for i, mode in enumerate(body.modes):
        where = f'{key}.modes.{i}.kind = "{mode.kind}"'
        if mode.kind == "torsion":
            errors.append(
                f'{where}: expected "lowest", "bending-xy", "bending-xz" or "axial": a shell that '
                "twists moves along y and z"
            )
        elif isinstance(mode, SpinningChoice):
            errors.append(
                f'{where}: expected "attachment" or "static-axial": the static shapes of a shell'
            )
    refuse(errors)
    own = {"body": name, "kind": "shell", "shell": shell, "mass_form": body.mass_form}
    spec = cast(ShellSpecification, {**own, **reduction(body)})
    return spec, [folder / body.shell, mesh]


def _shell(body: ShellBody, folder: Path) -> Any:
    table, file = shell_table(body, folder)
    table = {key: value for key, value in table.items() if key not in OF_SHELLS}
    mesh = table.get("mesh")
    if isinstance(mesh, dict):  # what is wrong with another value is said below
        mesh = dict(mesh)
        if body.parameters:
            mesh["parameters"] = {**mesh.get("parameters", {}), **body.parameters}
        if body.refine and isinstance(mesh.get("refine", 0), int):
            mesh["refine"] = mesh.get("refine", 0) + body.refine
        table["mesh"] = mesh
    # a description alone must request a result
    spec = shell_spec({**table, "frequencies": {}}, file)
    del spec["elements"]["mass_form"]  # the body's
    parts = ("allow", "mesh", "materials", "laminates", "regions", "elements", "stiffeners")
    return {key: spec[key] for key in parts if key in spec}


def _groups(key: str, body: ShellBody, mesh: Path) -> list[str]:
    """Groups that a .msh file does not have; only gmsh knows those of a script."""
    if mesh.suffix != ".msh":
        return []
    known = [name for names in physical_groups(mesh) for name in names]
    return [
        f'{key}.interfaces.{name}.at = "{interface.at}": {os.path.basename(mesh)} has no physical '
        f"group of this name, it has {few(known)}"
        for name, interface in body.interfaces.items()
        if interface.at not in known
    ]


def solid_body_spec(
    name: str, body: SolidBody, folder: Path
) -> tuple[SolidSpecification, list[Path]]:
    """Return the same of a solid.

    Parameters
    ----------
    name : name of the body
    body : its table in the case
    folder : folder for relative names of files
    """
    key, file = f"bodies.{name}", folder / body.solid
    try:
        table = read_toml(file, "solid description")
        kept = {k: v for k, v in table.items() if k not in OF_SOLIDS}
        _, solid = solid_table(kept, file, body.size)
    except InputError as error:
        raise under(f"{key}.solid", error) from error
    errors = check_places(key, body) + [
        f'{key}.modes.{i}.kind = "{mode.kind}": expected "lowest" or "attachment": the modes of '
        "a solid"
        for i, mode in enumerate(body.modes)
        if not _of_solids(mode)
    ]
    refuse(errors)
    own = {"body": name, "kind": "solid", "solid": solid}
    spec = cast(SolidSpecification, {**own, **reduction(body)})
    return spec, [file, Path(solid["mesh"]["file"])]


def _of_solids(mode: Modes) -> bool:
    lowest = isinstance(mode, ModeChoice) and mode.kind == "lowest"
    return lowest or isinstance(mode, AttachmentChoice)
