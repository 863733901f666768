"""A URDF file to the folder of a case: case.toml, and a surface of each body for pictures."""

import re
from collections.abc import Collection, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...errors import InputError, printable, refuse
from ...math.arrays import Array
from ...package.common.files import temporary_sibling, write_text
from ...package.common.plain_data import toml_value
from ...results.surfaces import BOX, SIGNS, halved, prism, stl_triangles, unit_sphere
from ..tolerances import LONG
from .case import Body, Moved, RobotCase, robot_case
from .urdf import Robot, Shape, read_urdf

# Surfaces of links for pictures: boxes, cylinders, spheres, mesh files; one STL for a body.

MOST_TRIANGLES = 800  # of a body: a report draws each in every frame
ROUND = 24  # sides of cylinders and spheres
INSTALL = "pip install trimesh pycollada"


def body_surface(robot: Robot, body: Body, packages: Mapping[str, Path]) -> Array:
    """Return the triangles (f, 3, 3) of the links of a body, in its axes [m].

    Parameters
    ----------
    robot : the robot
    body : one of its bodies
    packages : folders of ROS packages by name

    Raises
    ------
    InputError
        One line for each mesh that is missing or cannot be read.
    """
    parts, errors = [np.zeros((0, 3, 3))], list[str]()
    for name, pose in body.links.items():
        for shape in robot.links[name].shapes:
            try:
                triangles = _triangles(shape, robot.file, packages)
            except InputError as error:
                errors.append(f"{robot.file}:{shape.line}: <link {name}>, <{shape.kind}>: {error}")
                continue
            if (size := float(np.ptp(triangles.reshape(-1, 3), axis=0).max())) > LONG:
                text = f"{size:.4g} m wide; expected m, found some like mm; or --no-meshes"
                errors.append(f"{robot.file}:{shape.line}: <link {name}>, <{shape.kind}>: {text}")
            at = pose @ shape.pose
            parts.append(triangles @ at.A.T + at.p)
    refuse(errors)
    return fewer(np.concatenate(parts), MOST_TRIANGLES)


def fewer(triangles: Array, most: int) -> Array:
    """Return at most about `most` triangles (f, 3, 3): corners of a cell of a grid become one."""
    cells = 64.0
    whole = triangles
    while len(triangles) > most and cells > 2.0:
        corners = whole.reshape(-1, 3)
        low, span = corners.min(axis=0), float(np.ptp(corners, axis=0).max())
        cell = np.floor((corners - low) / (span / cells)).astype(np.int64)
        _, number = np.unique(cell, axis=0, return_inverse=True)
        number = number.reshape(-1)
        count = np.bincount(number)
        mean = np.column_stack([np.bincount(number, corners[:, k]) / count for k in range(3)])
        faces = number.reshape(-1, 3)
        faces = faces[
            (faces[:, 0] != faces[:, 1])
            & (faces[:, 1] != faces[:, 2])
            & (faces[:, 2] != faces[:, 0])
        ]
        _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
        triangles = mean[faces[np.sort(first)]]
        cells *= 0.8
    return triangles


def _triangles(shape: Shape, file: Path, packages: Mapping[str, Path]) -> Array:
    if shape.kind == "mesh":
        mesh = _mesh(mesh_file(shape.file, file, packages)) * np.array(shape.sizes)
        return mesh if np.prod(shape.sizes) > 0.0 else mesh[:, ::-1]  # mirrored: inside out
    if shape.kind == "box":
        points, faces = 0.5 * SIGNS * shape.sizes, halved(BOX)
    elif shape.kind == "cylinder":
        points, faces = prism(ROUND, shape.sizes[0], 0.5 * shape.sizes[1])
    else:
        points, cells = unit_sphere(ROUND)
        points, faces = shape.sizes[0] * points, halved(cells)
    return np.asarray(points[faces])


def mesh_file(name: str, urdf: Path, packages: Mapping[str, Path]) -> Path:
    """Return the path of a mesh: relative to the URDF, or in a ROS package.

    A package is a folder of that name above or beside a folder above the URDF, or one of
    `packages`.

    Parameters
    ----------
    name : `filename` of a mesh in the URDF
    urdf : file of the robot
    packages : folders of ROS packages by name

    Raises
    ------
    InputError
        No such file.
    """
    match = re.fullmatch(r"(?:package|model):/+([^/]+)/(.+)", name)
    if match is None:
        path = urdf.parent / re.sub(r"^file://", "", name)
        if not path.is_file():
            raise InputError(
                f'filename = "{name}": {path}: no such file; expected one beside the URDF, '
                "package://NAME/FILE, or --no-meshes"
            )
        return path
    package, rest = match.groups()
    if package in packages:
        places = [packages[package]]
    else:
        above = urdf.resolve().parents
        places = [p if p.name == package else p / package for p in above]
    for place in places:
        if (place / rest).is_file():
            return place / rest
    if package in packages:
        raise InputError(f'filename = "{name}": {places[0] / rest}: no such file')
    raise InputError(
        f'filename = "{name}": no folder "{package}" with this file above {urdf.parent}; expected '
        f"--package {package}=PATH, or --no-meshes"
    )


def _mesh(path: Path) -> Array:
    """Return the triangles (f, 3, 3) of a mesh file."""
    if path.suffix.lower() == ".stl":
        return stl_triangles(path)
    try:
        trimesh = import_module("trimesh")
    except ImportError:
        raise InputError(
            f"{path}: {path.suffix} needs trimesh; expected `{INSTALL}`, or --no-meshes"
        ) from None
    try:
        mesh = trimesh.load(path, force="mesh")
        return np.asarray(mesh.triangles, dtype=float)
    except ImportError as error:
        raise InputError(f"{path}: {error}; expected `{INSTALL}`, or --no-meshes") from None
    except Exception as error:  # of many kinds, by the format
        raise InputError(f"{path}: cannot be read: {error}") from None


STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("none", "<u2")])


def stl(triangles: Array) -> bytes:
    """Return triangles (f, 3, 3) as a binary STL file."""
    rows = np.zeros(len(triangles), dtype=STL)
    a, b, c = np.moveaxis(triangles, 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"], rows["corners"] = normal / np.maximum(size, 1e-300), triangles
    return b"plymotion".ljust(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()


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
        raise InputError(f"{target}: already exists; expected another folder, by --out")
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
