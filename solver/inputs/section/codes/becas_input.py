"""BECAS input folders: N2D.in, E2D.in, EMAT.in and MATPROPS.in.

    N2D.in       node x y
    E2D.in       cell n1 ... n8 (or n1 ... n4): quadrilaterals of 4 or 8 nodes, triangles of 3 or 6
                 nodes with zeros for the others, or with a repeated corner
    EMAT.in      cell material fibre_angle fibre_plane_angle [deg]
    MATPROPS.in  E1 E2 E3 G12 G13 G23 nu12 nu13 nu23 rho, a row for each material

x and y are x2 and x3, z is x1. The fibre plane angle turns x to the layer direction, and the fibre
angle turns the fibre from z towards it.
"""

import io
from pathlib import Path

import numpy as np

from ....errors import InputError
from ....math.arrays import Array, IntArray
from .per_cell import ABSENT, MOST_NODES, QUADRILATERAL, TRIANGLE, CellSection, Constants
from .vabs_input import ORTHOTROPIC

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
        words = " or ".join(map(str, columns))
        raise InputError(f"{file}: rows of {table.shape[1]} numbers, expected {words}")
    for row in np.flatnonzero((table != np.round(table))[:, :whole].any(axis=1)):
        raise InputError(f"{file}: row {row + 1}: expected whole numbers")
    numbers, count = np.unique(table[:, 0], return_counts=True)
    if whole and (count > 1).any():
        raise InputError(f"{file}: number {numbers[count > 1][0]:g} is there twice")
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
