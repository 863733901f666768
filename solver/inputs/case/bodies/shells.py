"""Shell bodies: their description and its checks."""

import os
from pathlib import Path
from typing import Any

from ....errors import InputError, few, under
from ....package.specification import ShellSpecification
from ...common.gmsh_file import physical_groups
from ...common.table import plain_table
from ...shell.expand import shell_spec
from ..tables.modes import ModeChoice, SpinningChoice, check_places
from ..tables.shell_schema import ShellBody
from .descriptions import shell_table

# Keys of a description for its own analysis; the mechanism supports and loads a body.
LEFT_OUT = ("links", "supports", "loads", "probes", "frequencies")


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
    if found := _groups(key, body, mesh) + _check_motion(key, body):
        raise InputError("\n".join(found))
    spec: ShellSpecification = {
        "body": name,
        "kind": "shell",
        "shell": shell,
        "mass_form": body.mass_form,
        "reference": plain_table(body.reference),
        "modes": [plain_table(mode) for mode in body.modes],
        "damping_ratio": body.damping_ratio,
        "interfaces": {k: plain_table(v) for k, v in body.interfaces.items()},
    }
    if body.second_order:
        spec["second_order"] = True
    return spec, [folder / body.shell, mesh]


def _check_motion(key: str, body: ShellBody) -> list[str]:
    """Return what is wrong with the interfaces that carry the frame, and with the modes."""
    found = check_places(key, body)
    found += [
        f'{key}.modes[{i}].kind = "torsion": expected "lowest", "bending-xy", "bending-xz" or '
        '"axial": a shell that twists moves along y and z'
        for i, mode in enumerate(body.modes)
        if isinstance(mode, ModeChoice) and mode.kind == "torsion"
    ]
    found += [
        f'{key}.modes[{i}].kind = "{mode.kind}": expected "attachment" or "static-axial": the '
        "static shapes of a shell"
        for i, mode in enumerate(body.modes)
        if isinstance(mode, SpinningChoice)
    ]
    return found


def _shell(body: ShellBody, folder: Path) -> Any:
    table, file = shell_table(body, folder)
    table = {key: value for key, value in table.items() if key not in LEFT_OUT}
    if body.parameters and isinstance(table.get("mesh"), dict):
        parameters = {**table["mesh"].get("parameters", {}), **body.parameters}
        table["mesh"] = {**table["mesh"], "parameters": parameters}
    if body.refine and isinstance(table.get("mesh"), dict):
        refine = table["mesh"].get("refine", 0)
        if isinstance(refine, int):  # what is wrong with another value is said below
            table["mesh"] = {**table["mesh"], "refine": refine + body.refine}
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
