"""Shell bodies: their description and its checks."""

import os
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..common import read_toml
from ..common.gmsh_file import physical_groups
from ..shell.expand import shell_spec
from .modes import ModeChoice, SpinningChoice, check_modes
from .schema import Mechanism, ShellBody

# Keys of a description for its own analysis; the mechanism supports and loads a body.
LEFT_OUT = ("links", "supports", "loads", "probes", "frequencies")


def shell_body_spec(name: str, body: ShellBody, folder: Path) -> dict[str, Any]:
    """Return the specification of one shell body for the preprocessor, plain JSON, SI and degrees.

    Parameters
    ----------
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        What is wrong with the description, one line each.
    """
    return {
        "body": name,
        "kind": "shell",
        "shell": _shell(body, folder),
        "mass_form": body.mass_form,
        "reference": body.reference.model_dump(exclude_none=True),
        "modes": [m.model_dump() for m in body.modes],
        "damping_ratio": body.damping_ratio,
        "interfaces": {k: v.model_dump(exclude_none=True) for k, v in body.interfaces.items()},
    }


def check_shell(key: str, body: ShellBody, folder: Path) -> list[str]:
    """Return errors of a shell body; `key` names it."""
    try:
        spec = _shell(body, folder)
    except InputError as error:
        return [f"{key}.shell: {line}" for line in str(error).splitlines()]
    found = _groups(key, body, Path(spec["mesh"]["file"]))
    places = {name: float(i) for i, name in enumerate(body.interfaces)}
    found += check_modes(key, body.reference, body.modes, places)
    for place in body.reference.places:
        if place in body.interfaces and body.interfaces[place].link != "rigid":
            found.append(
                f'{key}.interfaces.{place}.link = "{body.interfaces[place].link}": expected '
                '"rigid": it carries the body frame'
            )
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


def shell_sources(mechanism: Mechanism, folder: Path) -> list[Path]:
    """Return the source files of the shells of a mechanism."""
    found = []
    for body in mechanism.bodies.values():
        if isinstance(body, ShellBody):
            found += [folder / body.shell, Path(_shell(body, folder)["mesh"]["file"])]
    return found


def _shell(body: ShellBody, folder: Path) -> dict[str, Any]:
    file = folder / body.shell
    table = read_toml(file, "shell description")
    table = {key: value for key, value in table.items() if key not in LEFT_OUT}
    if body.parameters and isinstance(table.get("mesh"), dict):
        parameters = {**table["mesh"].get("parameters", {}), **body.parameters}
        table["mesh"] = {**table["mesh"], "parameters": parameters}
    # a description alone must request a result
    spec = shell_spec({**table, "frequencies": {}}, file)
    del spec["elements"]["mass_form"]  # the body's
    parts = ("mesh", "materials", "laminates", "regions", "elements", "stiffeners")
    return {key: spec[key] for key in parts if key in spec}


def _groups(key: str, body: ShellBody, mesh: Path) -> list[str]:
    """Groups that a .msh file does not have; only gmsh knows those of a script."""
    if mesh.suffix != ".msh":
        return []
    known = [name for names in physical_groups(mesh) for name in names]
    return [
        f'{key}.interfaces.{name}.at = "{interface.at}": {os.path.basename(mesh)} has no physical '
        f"group of this name, it has {', '.join(known)}"
        for name, interface in body.interfaces.items()
        if interface.at not in known
    ]
