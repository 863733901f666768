"""A URDF file to the folder of a case: case.toml, and a surface of each body for pictures."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Literal

from ...errors import InputError, printable, refuse
from ...package.common.files import temporary_sibling, write_text
from ...package.common.plain_data import toml_value
from .case import Moved, RobotCase, robot_case
from .pictures import body_surface, stl
from .urdf import read_urdf

HEAD = """\
# {title}: made by `plymotion import {file}`. The pose is that of all joints at 0.
# Keys, units and bounds: docs/case-reference.md; flexible links: docs/robots.md.
"""
REMARKS = {
    "joints": "Positions and axes are global, in the pose above; a place has the name of its joint",
    "forces": "URDF has no stiffness and restitution of stops: the effort of the joint pushes one "
    "in by 0.01 rad or m. Friction is smoothed below 0.01 rad/s or m/s",
    "couplings": "Joints that mimic others, from the pose above",
}


def import_robot(
    file: Path,
    out: Path,
    *,
    joints: Moved = "hold",
    base: Literal["fixed", "free"] = "fixed",
    keep_fixed: bool = False,
    meshes: bool = True,
    packages: Mapping[str, Path] | None = None,
    allow: Collection[str] = (),
) -> RobotCase:
    """Write the case of a robot into a new folder; see `robot_case`.

    Parameters
    ----------
    out : folder
    meshes : with pictures of the links
    packages : folders of ROS packages by name, before those above the file

    Raises
    ------
    InputError
        One line per mistake; nothing is written.
    """
    robot = read_urdf(file)
    made = robot_case(robot, joints=joints, base=base, keep_fixed=keep_fixed, allow=allow)
    pictures, errors = dict[str, bytes](), list[str]()
    for name, body in made.bodies.items() if meshes else ():
        try:
            triangles = body_surface(robot, body, packages or {})
        except InputError as error:
            errors.append(str(error))
            continue
        if len(triangles) and name in made.tables["bodies"]:
            pictures[f"meshes/{name}.stl"] = stl(triangles)
            made.tables["bodies"][name]["picture"] = f"meshes/{name}.stl"
    refuse(errors)
    target = out / "case.toml"
    if target.exists():
        raise InputError(f"{target}: is there already; expected another folder, by --out")
    for name, content in pictures.items():
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(path, own=False) as temporary:
            temporary.write_bytes(content)
    head = HEAD.format(title=printable(str(made.tables["title"])), file=printable(file.name))
    notes = "".join(f"# {printable(note)}\n" for note in made.notes)
    write_text(target, head + notes + toml_text(made.tables), own=False)
    return made


def toml_text(tables: Mapping[str, Any]) -> str:
    """Return a case as TOML: named tables by headings, what is in them inline."""

    def given(table: Mapping[str, Any]) -> list[str]:
        return [f"{key} = {toml_value(value)}" for key, value in table.items()]

    lines = given({key: value for key, value in tables.items() if not isinstance(value, dict)})
    for group, table in tables.items():
        if not isinstance(table, dict):
            continue
        if group in REMARKS:
            lines += ["", f"# {REMARKS[group]}."]
        if not any(isinstance(v, dict) for v in table.values()):
            lines += ["", f"[{group}]", *given(table)]
            continue
        for name, entry in table.items():
            lines += [
                "",
                f"[{group}.{name}]",
                *(f"{k} = {toml_value(v)}" for k, v in entry.items()),
            ]
    return "\n".join(lines) + "\n"
