"""Matrix Market files of K and M, CSV files of nodes, dofs and cells: for every other code."""

from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import Cells, FreeBody, free_body, rows_of
from ..import_table import Files, text_lines

KEYS = ("stiffness", "mass", "nodes", "dofs")
LONGEST_LINE = 1_000_000  # characters of a head or a size
WORDS = (("x", "ux"), ("y", "uy"), ("z", "uz"), ("rx",), ("ry",), ("rz",))
DIRECTIONS = {
    word: number for number, words in enumerate(WORDS, 1) for word in (*words, str(number))
}


def read(files: Files) -> FreeBody:
    """Body from `stiffness`, `mass` (.mtx), `nodes`, `dofs` and, if given, `cells` (.csv).

    Raises InputError for a file that does not have the form of docs/exchange.md.
    """
    files.only(KEYS, ("cells",))
    K, M = (_matrix(files.path(key)) for key in ("stiffness", "mass"))
    ids, nodes = _nodes(files.path("nodes"))
    dofs = _dofs(files.path("dofs"))
    cells = _cells(files.path("cells"), ids) if "cells" in files else None
    return free_body(files.where, K, M, nodes, ids, dofs, cells, notes=files.notes())


def _matrix(path: Path) -> sp.csr_matrix:
    """A real Matrix Market file; `symmetric` files hold one triangle and are completed.

    It is not read by SciPy, whose reader ends the process at some damaged files.
    """
    kind, symmetric, sizes = _header(path)
    n, m = sizes[:2]
    sparse = kind == "coordinate"
    triangle = symmetric and not sparse
    expected = sizes[2] if sparse else n * (n + 1) // 2 if triangle else n * m
    most = path.stat().st_size  # a number takes a byte at least, and a row of a body a number
    if not 0 < min(n, m) <= max(n, m, expected) <= most or (symmetric and n != m):
        raise InputError(
            f"{path}: {n} x {m} with {expected} numbers: expected the size of a matrix, with not "
            f"more rows and numbers than the {most} bytes of the file hold"
        )
    columns = 3 if sparse else 1
    with path.open(encoding="ascii", errors="replace") as file:
        lines = _lines(file)
        next(lines)  # the size
        try:
            rows = np.loadtxt((line for _, line in lines), comments=None, ndmin=2)
        except ValueError as error:
            raise _wrong_line(path, columns) from error
    if len(rows) != expected:
        raise InputError(
            f"{path}: truncated: expected {expected} lines of numbers, found {len(rows)}"
        )
    if rows.shape[1] != columns:
        raise _wrong_line(path, columns)
    if sparse:
        at = rows[:, :2].T - 1.0
        if (at != np.floor(at)).any() or at.min() < 0 or (at >= [[n], [m]]).any():
            raise InputError(f"{path}: expected rows from 1 to {n} and columns from 1 to {m}")
        i, j = at.astype(np.int64)
        if symmetric and (i > j).any() and (i < j).any():
            raise InputError(f"{path}: symmetric: expected one triangle, found entries of both")
    elif symmetric:
        j, i = np.triu_indices(n)  # the lower triangle, column by column
    else:
        j, i = np.divmod(np.arange(n * m), n)
    A = sp.csr_matrix((rows[:, -1], (i, j)), (n, m))
    return sp.csr_matrix(A + A.T - sp.diags(A.diagonal())) if symmetric else A


def _lines(file: TextIO) -> Iterator[tuple[int, str]]:
    """Yield the lines of the size and the numbers, with their numbers in the file."""
    for number, line in enumerate(file, 1):
        if not line.startswith("%") and not line.isspace():
            yield number, line


def _wrong_line(path: Path, columns: int) -> InputError:
    """Return the error of the first line without so many numbers."""
    with path.open(encoding="ascii", errors="replace") as file:
        lines = _lines(file)
        next(lines)
        for number, line in lines:
            try:
                count = len([float(word) for word in line.split()])
            except ValueError:
                count = 0
            if count != columns:
                message = f"expected {columns} numbers, found {line[:60]!r}"
                return InputError(f"{path}:{number}: {message}")
    return InputError(f"{path}: expected lines of {columns} numbers")


def _header(path: Path) -> tuple[str, bool, list[int]]:
    """Return "coordinate" or "array", whether one triangle stands for both, and the sizes."""
    with path.open(encoding="ascii", errors="replace") as file:
        words = file.readline(LONGEST_LINE).lower().split()
        known = (
            ("%%matrixmarket",),
            ("matrix",),
            ("coordinate", "array"),
            ("real", "double", "integer"),
            ("general", "symmetric"),
        )
        if len(words) != 5 or any(w not in names for w, names in zip(words, known, strict=True)):
            raise InputError(
                f"{path}:1: {' '.join(words)[:60]!r}: expected %%MatrixMarket matrix, coordinate "
                "or array, real or integer, general or symmetric"
            )
        number, line = 1, "%"
        while line.startswith("%") or line.isspace():
            number, line = number + 1, file.readline(LONGEST_LINE)
    sizes = [int(word) for word in line.split() if word.isdecimal() and len(word) < 20]
    if len(sizes) != (3 if words[2] == "coordinate" else 2):
        raise InputError(f"{path}:{number}: no size of a matrix: {line[:60]!r}")
    return words[2], words[4] == "symmetric", sizes


def table_rows(path: Path, columns: str) -> list[tuple[int, list[str]]]:
    """Numbered lines of a CSV file, split; without comments, empty lines and a line of names."""
    rows = []
    for number, line in enumerate(text_lines(path), 1):
        text = line.split("#")[0].replace(";", ",").strip()
        if text:
            rows.append((number, [part.strip() for part in text.split(",")]))
    if rows and not rows[0][1][0].lstrip("+-.")[:1].isdecimal():
        rows = rows[1:]
    if not rows:
        raise InputError(f"{path}: no line with the columns {columns}")
    return rows


def _nodes(path: Path) -> tuple[IntArray, Array]:
    ids, points = [], []
    for number, row in table_rows(path, "node, x, y, z"):
        try:
            label, point = int(row[0]), [float(part) for part in row[1:]]
        except ValueError:
            label, point = 0, []
        if len(point) != 3 or not np.isfinite(point).all():
            raise InputError(f"{path}:{number}: expected node, x, y, z; found {', '.join(row)}")
        ids.append(label)
        points.append(point)
    return np.array(ids, dtype=np.int64), np.array(points)


def _dofs(path: Path) -> IntArray:
    dofs = []
    for number, row in table_rows(path, "node, direction"):
        direction = DIRECTIONS.get(row[1].lower()) if len(row) == 2 else None
        if direction is None or not row[0].isdecimal():
            raise InputError(
                f"{path}:{number}: expected node, direction (x y z rx ry rz or 1 to 6); found "
                f"{', '.join(row)}"
            )
        dofs.append((int(row[0]), direction))
    return np.array(dofs, dtype=np.int64)


def _cells(path: Path, ids: IntArray) -> Cells:
    cells, types = [], []
    for number, row in table_rows(path, "VTK type, nodes of the cell"):
        if not all(part.isdecimal() for part in row) or len(row) < 2:
            raise InputError(
                f"{path}:{number}: expected a VTK type and labels of nodes, found {', '.join(row)}"
            )
        types.append(int(row[0]))
        labels = np.array(row[1:], dtype=np.int64)
        cells.append(rows_of(labels, ids, f"{path}:{number}").tolist())
    return Cells.of(cells, types)
