"""Mesh, materials and orientations of a section as input of VABS and of BECAS.

Each cell has one ply and one layer direction, those of its middle; `turning_cells` counts cells in
which the direction turns more.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import InputError
from ....inputs.section.vabs_input import OF_VABS
from ....math.arrays import Array, IntArray
from ....package.common.anisotropic import elastic_from_dict
from ....package.section.schema import CORNERS, SectionFile
from .text import written

KEYS = ("E1", "E2", "E3", "G12", "G13", "G23", "nu12", "nu13", "nu23")
TO_VABS = np.argsort(OF_VABS)
BECAS_FILES = ("N2D.in", "E2D.in", "EMAT.in", "MATPROPS.in")


def write_vabs(section: SectionFile, file: Path) -> Path:
    """Write a VABS input file (format 1) for the 6x6 stiffness; returns the file.

    Raises
    ------
    InputError
        A material without elastic constants.
    """
    mesh, recovery = section.mesh, section.recovery
    names = list(recovery.materials)
    curved = section.initial_curvature is not None
    lines = [f"1 {len(recovery.plies)}", "1 0 0", f"{int(curved)} 0 0 0"]
    if section.initial_curvature is not None:
        lines.append(_row(section.initial_curvature))
    lines.append(f"{len(mesh.nodes)} {len(mesh.cell_types)} {len(names)}")
    lines += [f"{i} {_row(x)}" for i, x in enumerate(mesh.nodes, start=1)]
    lines += [f"{i} {_nine(nodes, kind)}" for i, (nodes, kind) in _cells(section)]
    angles = np.degrees(np.arctan2(*mesh.layer_direction.T[::-1]))
    lines += [
        f"{i} {ply + 1} {angle:.17g}"
        for i, (ply, angle) in enumerate(zip(mesh.ply, angles, strict=True), start=1)
    ]
    lines += [
        f"{i} {names.index(ply.material) + 1} {ply.angle_deg:.17g}"
        for i, ply in enumerate(recovery.plies, start=1)
    ]
    for i, name in enumerate(names, start=1):
        table = recovery.materials[name]
        if table.get("kind") == "anisotropic":
            material = elastic_from_dict(table, f"materials.{name}", massless=True)
            C = material.stiffness_M[np.ix_(TO_VABS, TO_VABS)]
            lines += [f"{i} 2", *(_row(C[j, j:]) for j in range(6)), f"{table['rho']:.17g}"]
            continue
        constants, rho = _constants(name, table)
        lines += [f"{i} 1", *(_row(constants[j : j + 3]) for j in (0, 3, 6)), f"{rho:.17g}"]
    return written(file, lines)


def write_becas(section: SectionFile, folder: Path) -> Path:
    """Write the input files of BECAS into a folder; returns the folder.

    Nine-node cells lose the node in their centre: BECAS has quadrilaterals of 4 and 8 nodes.

    Raises
    ------
    InputError
        Triangles, which BECAS does not read in this form; a material without elastic constants.
    """
    mesh, recovery = section.mesh, section.recovery
    names = list(recovery.materials)
    rows = []
    for i, (nodes, kind) in _cells(section):
        if CORNERS[kind] == 3:
            raise InputError(f"section {section.name}: expected quadrilaterals only, for BECAS")
        nodes = nodes[:8]
        rows.append([i, *(n + 1 for n in nodes), *[0] * (8 - len(nodes))])
    used = sorted({n for row in rows for n in row[1:] if n})
    angles = np.degrees(np.arctan2(*mesh.layer_direction.T[::-1]))
    tables = (
        [f"{n} {_row(mesh.nodes[n - 1])}" for n in used],
        [" ".join(map(str, row)) for row in rows],
        [
            f"{i} {names.index(recovery.plies[ply].material) + 1} "
            f"{recovery.plies[ply].angle_deg:.17g} {angle:.17g}"
            for i, (ply, angle) in enumerate(zip(mesh.ply, angles, strict=True), start=1)
        ],
        [
            _row([*constants, rho])
            for constants, rho in (_constants(n, recovery.materials[n]) for n in names)
        ],
    )
    folder.mkdir(parents=True, exist_ok=True)
    for name, lines in zip(BECAS_FILES, tables, strict=True):
        written(folder / name, lines)
    return folder


def turning_cells(section: SectionFile) -> int:
    """Number of cells whose ply or layer direction is not that of their middle everywhere."""
    recovery = section.recovery
    fibre = recovery.A_BM[:, :, 0]
    other = np.abs(fibre - section.mesh.fibre[recovery.cell]).max(axis=1) > 1e-9
    other |= recovery.ply != section.mesh.ply[recovery.cell]
    return int(np.unique(recovery.cell[other]).size)


def _cells(section: SectionFile) -> Iterable[tuple[int, tuple[IntArray, int]]]:
    """Number from 1, nodes and VTK type of every cell."""
    mesh = section.mesh
    parts = np.split(mesh.connectivity, mesh.offsets[1:-1])
    pairs = zip(parts, map(int, mesh.cell_types), strict=True)
    return enumerate(pairs, start=1)


def _nine(nodes: IntArray, kind: int) -> str:
    """Nodes from 1 in nine places; the fourth of a triangle is 0."""
    numbers = [int(n) + 1 for n in nodes]
    if CORNERS[kind] == 3:
        numbers = [*numbers[:3], 0, *numbers[3:]]
    return " ".join(map(str, [*numbers, *[0] * (9 - len(numbers))]))


def _constants(name: str, table: dict[str, Any]) -> tuple[list[float], float]:
    """Nine constants and the density of a material."""
    if table.get("kind") == "isotropic":
        E, nu = float(table["E"]), float(table["nu"])
        return [E] * 3 + [E / (2.0 * (1.0 + nu))] * 3 + [nu] * 3, float(table["rho"])
    if not all(key in table for key in KEYS):
        raise InputError(f"materials.{name}: expected nine elastic constants in the section file")
    return [float(table[key]) for key in KEYS], float(table["rho"])


def _row(values: Iterable[float] | Array) -> str:
    return " ".join(f"{float(value):.17g}" for value in values)
