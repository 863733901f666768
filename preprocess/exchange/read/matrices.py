"""Matrix Market files of K and M, CSV files of nodes, dofs and cells: for every other code."""

import io
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import Cells, FreeBody
from ..from_matrices import free_body
from ..reduce import rows_of
from .files import Files, text_lines

KEYS = ("stiffness", "mass", "nodes", "dofs")
MOST_ROWS = 100_000_000
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
    """A Matrix Market file; `symmetric` files hold one triangle and are completed."""
    whole = _check_lines(path)
    try:
        # SciPy reads beyond the end of a number that ends with the file.
        source = path if whole else io.BytesIO(path.read_bytes() + b"\n")
        return sp.csr_matrix(scipy.io.mmread(source))
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{path}: expected a Matrix Market file ({error})") from error


def _check_lines(path: Path) -> bool:
    """Tell whether the last line is whole.

    Raises InputError for what SciPy does not survive, or fills the memory with: no rows, fewer
    lines than the file announces, a line of too few numbers.
    """
    with path.open("rb") as file:
        words = file.readline().lower().split()
        sparse = b"coordinate" in words
        size: list[int] = []
        own = {b"pattern": 0, b"complex": 2}.get(words[3] if len(words) > 3 else b"", 1)
        least = own + 2 * sparse
        line, lines = b"", 0
        for number, line in enumerate(file, 2):
            if line[:1] == b"%" or not line.strip():
                continue
            if not size:
                size = [int(word) for word in line.split() if word.isdigit()]
                if len(size) != 2 + sparse or not 0 < max(size[:2]) <= MOST_ROWS or 0 in size[:2]:
                    raise InputError(f"{path}:{number}: no size of a matrix: {line[:60]!r}")
                continue
            lines += 1
            if len(line.split(None, least)) < least:
                raise InputError(f"{path}:{number}: expected {least} numbers, found {line[:60]!r}")
    n, m = size[:2] or (0, 0)
    expected = size[2] if len(size) > 2 else n * (n + 1) // 2 if b"symmetric" in words else n * m
    if lines < expected:
        raise InputError(f"{path}: truncated: expected {expected} lines of numbers, found {lines}")
    return line.endswith(b"\n")


def table_rows(path: Path, columns: str) -> list[tuple[int, list[str]]]:
    """Numbered lines of a CSV file, split; without comments, empty lines and a line of names."""
    rows = []
    for number, line in enumerate(text_lines(path), 1):
        text = line.split("#")[0].replace(";", ",").strip()
        if text:
            rows.append((number, [part.strip() for part in text.split(",")]))
    if rows and not rows[0][1][0].lstrip("+-").isdecimal():
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
    found = []
    for number, row in table_rows(path, "node, direction"):
        direction = DIRECTIONS.get(row[1].lower()) if len(row) == 2 else None
        if direction is None or not row[0].isdecimal():
            raise InputError(
                f"{path}:{number}: expected node, direction (x y z rx ry rz or 1 to 6); found "
                f"{', '.join(row)}"
            )
        found.append((int(row[0]), direction))
    return np.array(found, dtype=np.int64)


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
