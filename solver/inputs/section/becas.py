"""Sections whose files give the orientation of every cell; the input files of BECAS.

Angles are ours and those of VABS: theta1 turns x2 to the layer direction y2, theta3 turns the fibre
from x1 towards y2. The files of a BECAS folder:

    N2D.in       node x y
    E2D.in       cell n1 ... n8 (or n1 ... n4): quadrilaterals of 4 or 8 nodes, triangles of 3 or 6
                 nodes with zeros for the others, or with a repeated corner
    EMAT.in      cell material fibre_angle fibre_plane_angle [deg]
    MATPROPS.in  E1 E2 E3 G12 G13 G23 nu12 nu13 nu23 rho, a row for each material

x and y are x2 and x3, z is x1. The fibre plane angle turns x to the layer direction, and the fibre
angle turns the fibre from z towards it.
"""

import io
import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray
from ...package.common.materials import MaterialError, elastic_from_dict
from .foreign import write_npz

TRIANGLE, QUADRILATERAL = 0, 1
ABSENT = -1
MOST_NODES = 9
ORTHOTROPIC = ("E1", "E2", "E3", "G12", "G13", "G23", "nu12", "nu13", "nu23")


Constants = dict[str, float | str | list[float]]  # of a material


@dataclass(frozen=True)
class CellSection:
    """Mesh and orientation; `n` counts nodes, `c` cells.

    Attributes
    ----------
    points : (n, 2) [m]
    nodes : (c, 9) rows of points: corners, middles of the edges from that of the first two corners,
        centre; ABSENT where there is none
    kind : (c,) TRIANGLE or QUADRILATERAL
    theta1 : (c, 1) or (c, 9) angle of the layer direction, for the cell or at its nodes [deg]
    ply : (c,) row of plies
    plies : material and theta3 [deg] of each
    materials : constants by name, as in a description
    curvature : (3,) initial twist and curvature [rad/m]
    not_computed : models that the file asks for and that are not computed
    places : file, and line or row, of each material, for messages
    """

    file: Path
    points: Array
    nodes: IntArray
    kind: IntArray
    theta1: Array
    ply: IntArray
    plies: list[tuple[str, float]]
    materials: dict[str, Constants]
    curvature: tuple[float, float, float] = (0.0, 0.0, 0.0)
    title: str = ""
    not_computed: list[str] = field(default_factory=list)
    places: dict[str, str] = field(default_factory=dict)


def cell_section_spec(section: CellSection, folder: Path) -> dict[str, object]:
    """Return the specification of a section; its arrays are written to a folder.

    The warping has the functions of the nodes of the file's cells, so that the result can be
    compared digit by digit.

    Raises
    ------
    InputError
        Cells without a ply, nodes that do not exist, impossible constants of a material in use.
        A ply without cells is left out.
    """
    if section.nodes.max() >= len(section.points):
        raise InputError(f"{section.file}: a cell has a node that does not exist")
    used = np.unique(section.ply)
    names = [f"ply-{row + 1}" for row in used]
    arrays, digest = write_npz(
        folder,
        section.file.stem,
        points=section.points,
        cells=section.nodes,
        kind=section.kind,
        layer_angle=section.theta1,
        cell_type=np.array("mixed"),
        region=np.searchsorted(used, section.ply),
        region_names=np.array(names, dtype=str),
    )
    regions = {}
    for name, row in zip(names, used, strict=True):
        material, angle = section.plies[row]
        regions[name] = {
            "plies": [{"material": material, "angle_deg": angle}],
            "direction": {"cells": True},
        }
    used_materials = {section.plies[row][0] for row in used}
    for name in sorted(used_materials):  # others may have any numbers
        try:
            elastic_from_dict(section.materials[name], section.places[name], massless=True)
        except MaterialError as error:
            raise InputError(str(error)) from error
    spec: dict[str, object] = {
        "name": section.file.stem,
        "title": section.title or section.file.name,
        "convention": "contour",
        "mesh": {"arrays": os.path.relpath(arrays), "sha256": digest, "degree": "mesh"},
        "materials": {n: m for n, m in section.materials.items() if n in used_materials},
        "regions": regions,
    }
    if any(section.curvature):
        spec["initial_curvature"] = list(section.curvature)
    if section.not_computed:
        spec["not_computed"] = section.not_computed
    return spec


AS_MATLAB = str.maketrans({",": " ", "d": "e", "D": "e"})
FILES = ("N2D.in", "E2D.in", "EMAT.in", "MATPROPS.in")


def is_becas(folder: Path) -> bool:
    """Return True for a folder with the input files of BECAS."""
    return folder.is_dir() and all((folder / name).is_file() for name in FILES)


def read_becas(folder: Path) -> CellSection:
    """Read the input files of BECAS in a folder.

    Raises
    ------
    InputError
        Rows of another form, unknown nodes or materials.
    """
    node = _table(folder / FILES[0], (3,), 1)
    cell = _table(folder / FILES[1], (5, 9), 9)
    orientation = _table(folder / FILES[2], (4,), 2)
    constants = _table(folder / FILES[3], (10,), 0)
    nodes, kind = _cells(folder, cell, {int(n): i for i, n in enumerate(node[:, 0])})
    row = {int(number): i for i, number in enumerate(orientation[:, 0])}
    missing = [int(n) for n in cell[:, 0] if int(n) not in row]
    if missing:
        raise InputError(f"{folder / FILES[2]}: no row for cell {missing[0]}")
    of_cells = orientation[[row[int(n)] for n in cell[:, 0]]]
    plies: dict[tuple[str, float], int] = {}
    ply = np.array(
        [
            plies.setdefault((_material(folder, m, len(constants)), float(angle)), len(plies))
            for m, angle in of_cells[:, 1:3]
        ]
    )
    materials: dict[str, Constants] = {
        f"material-{i}": {
            "kind": "orthotropic",
            **{key: float(v) for key, v in zip((*ORTHOTROPIC, "rho"), values, strict=True)},
        }
        for i, values in enumerate(constants, start=1)
    }
    return CellSection(
        folder,
        node[:, 1:],
        nodes,
        kind,
        of_cells[:, 3:],
        ply,
        list(plies),
        materials,
        places={name: f"{folder / FILES[3]}: {name}" for name in materials},
    )


def _material(folder: Path, number: float, count: int) -> str:
    if number != int(number) or not 1 <= number <= count:
        raise InputError(
            f"{folder / FILES[2]}: material {number:g}: expected a row of {FILES[3]}, 1 to {count}"
        )
    return f"material-{int(number)}"


def _table(file: Path, columns: tuple[int, ...], whole: int) -> Array:
    """Numbers of a file; commas may part them, and exponents may have a D, as MATLAB reads them.

    Parameters
    ----------
    columns : how many numbers a row may have
    whole : how many of them are whole, the first one of another value in each row
    """
    try:
        text = file.read_text(encoding="utf-8-sig").translate(AS_MATLAB)
        table = np.loadtxt(io.StringIO(text), ndmin=2, comments=("%", "#", "!"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: expected rows of numbers: {error}") from error
    for row in np.flatnonzero(~np.isfinite(table).all(axis=1)):
        raise InputError(
            f"{file}: row {row + 1}: expected finite numbers, found {table[row].tolist()}"
        )
    if not table.size or table.shape[1] not in columns:
        expectation = " or ".join(map(str, columns))
        raise InputError(f"{file}: rows of {table.shape[1]} numbers, expected {expectation}")
    for row in np.flatnonzero((table != np.round(table))[:, :whole].any(axis=1)):
        raise InputError(f"{file}: row {row + 1}: expected whole numbers")
    numbers, count = np.unique(table[:, 0], return_counts=True)
    if whole and (count > 1).any():
        raise InputError(f"{file}: number {numbers[count > 1][0]:g} occurs twice")
    return table


def _cells(folder: Path, table: Array, row_of: dict[int, int]) -> tuple[IntArray, IntArray]:
    """Nodes of each cell in our order, and its kind; `row_of` the number of a node."""
    nodes = np.full((len(table), MOST_NODES), ABSENT)
    kind = np.full(len(table), QUADRILATERAL)
    for i, (number, *listed) in enumerate(table.astype(np.int64).tolist()):
        for n in listed:
            if n and n not in row_of:
                raise InputError(f"{folder / FILES[1]}: cell {number}: node {n} does not exist")
        rows = [row_of[n] if n else ABSENT for n in listed] + [ABSENT] * (8 - len(listed))
        corners, middles = rows[:4], rows[4:]
        if corners[3] in (ABSENT, corners[2]):  # n1 n2 n3 (n3): a triangle
            kind[i] = TRIANGLE
            middles = [middles[0], middles[1], middles[3] if middles[3] != ABSENT else middles[2]]
            rows = [*corners[:3], *middles]
        present = [n for n in rows if n != ABSENT]
        if ABSENT in rows[:3] or len(set(present)) < len(present):
            raise InputError(f"{folder / FILES[1]}: cell {number}: expected each node once")
        nodes[i, : len(rows)] = rows
    return nodes, kind
