"""Laminated cylinders as shells: meshes, supports and loads for buckling."""

from pathlib import Path
from typing import Any

import numpy as np
from samples.shell_model import laminate

LAMINA = {
    "kind": "orthotropic",
    "E1": 40.0, "E2": 1.0, "E3": 1.0, "G12": 0.6, "G13": 0.6, "G23": 0.5,
    "nu12": 0.25, "nu13": 0.25, "nu23": 0.25, "rho": 1.0,
}  # fmt: skip


def write_cylinder(
    path: Path,
    radius: float,
    length: float,
    n: tuple[int, int],
    degrees: float = 360.0,
    *,
    triangles: bool = False,
) -> Path:
    """A gmsh file (format 2.2) of n[0] x n[1] quadrilaterals or pairs of triangles.

    Region "wall", curves near and far, of a part of the circle first and second, point "corner".
    The normal is outwards.
    """
    closed = degrees == 360.0
    columns = n[1] if closed else n[1] + 1
    angle = np.radians(degrees) * np.arange(columns) / n[1]
    x = length * np.arange(n[0] + 1) / n[0]
    number = 1 + np.arange((n[0] + 1) * columns).reshape(n[0] + 1, columns)
    places = [(a, radius * np.sin(t), radius * np.cos(t)) for a in x for t in angle]
    after = np.roll(number, -1, axis=1)[:, : n[1]]
    before = number[:, : n[1]]
    corners = [before[:-1], before[1:], after[1:], after[:-1]]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    rows = [[3, 1, *q] for q in quads]
    if triangles:
        rows = [[2, 1, *q[list(some)]] for q in quads for some in ((0, 1, 2), (0, 2, 3))]
    lines = {"near": (before[0], after[0]), "far": (before[-1], after[-1])}
    if not closed:
        lines |= {"first": (number[:-1, 0], number[1:, 0])}
        lines |= {"second": (number[:-1, -1], number[1:, -1])}
    for tag, ends in enumerate(lines.values(), start=2):
        rows += [[1, tag, *pair] for pair in np.stack(ends, axis=-1)]
    rows.append([15, len(lines) + 2, number[0, 0]])
    names = [
        f'0 {len(lines) + 2} "corner"',
        '2 1 "wall"',
        *(f'1 {tag} "{name}"' for tag, name in enumerate(lines, start=2)),
    ]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names]
    text += ["$EndPhysicalNames", "$Nodes", str(len(places))]
    text += [f"{i} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(
        ([float(c) for c in place] for place in places), start=1)]  # fmt: skip
    text += ["$EndNodes", "$Elements", str(len(rows))]
    text += [
        f"{i} {row[0]} 2 {row[1]} {row[1]} {' '.join(map(str, row[2:]))}"
        for i, row in enumerate(rows, start=1)
    ]
    path.write_text("\n".join([*text, "$EndElements"]) + "\n")
    return path


def cylinder(
    file: Path, angles: list[float], thickness: float, load: str, sector: bool = True
) -> dict[str, Any]:
    """A quarter (or all) of a cylinder under a membrane state of stress, with ends SS3.

    `load` is "compression" (1 N/m), "pressure" (1 Pa from outside) or "torsion" (1 N m about the
    axis, of the whole). Angles count from the axis; plies from the inside outwards. The prestress
    is even: rotations are held.
    """
    ends = {"fixed": ["uy", "uz", "rx"], "only": "modes"}
    supports: dict[str, Any] = {
        "near": {"at": "near", **ends},
        "far": {"at": "far", **ends},
        "even": {"at": "wall", "fixed": ["rx", "ry", "rz"], "only": "loads"},
    }
    supports["axial"] = {"at": "corner", "fixed": ["ux"], "only": "modes"}
    if not sector:
        supports["place"] = {"at": "corner", "fixed": ["uy", "uz"], "only": "loads"}
    else:
        supports["first"] = {"at": "first", "fixed": "symmetry-y"}
        supports["second"] = {"at": "second", "fixed": "symmetry-z"}
    loads: dict[str, Any] = {
        "compression": {"far": {"at": "far", "force_per_length": [-1.0, 0.0, 0.0]}},
        "pressure": {"wall": {"at": "wall", "pressure": -1.0}},
    }
    supports["still"] = {"at": "near", "fixed": ["ux"], "only": "loads"}
    links = {}
    if load == "torsion":
        links["end"] = {"at": "far", "kind": "average"}
        loads["torsion"] = {"end": {"at": "end", "moment": [1.0, 0.0, 0.0]}}
        supports["still"]["fixed"] = ["ux", "uy", "uz"]
        del supports["even"], supports["place"]
    return {
        "mesh": {"file": str(file)},
        "materials": {"ply": LAMINA},
        "laminates": {"wall": laminate("ply", angles, thickness, "5/6")},
        "regions": {"wall": {"laminate": "wall", "axis": [1.0, 0.0, 0.0]}},
        "supports": supports,
        "links": links,
        "loads": {load: loads[load]},
        "buckling": {"count": 2},
    }
