"""The library that reads binary files of ANSYS: optional, found when a file asks for it."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import Cells
from ..reduce import rows_of

# The library gives elements with midside nodes the VTK type of those without.
WITH_MIDSIDES = {(12, 20): 25, (10, 10): 24, (13, 15): 26, (14, 13): 27, (9, 8): 23, (5, 6): 22}
PACKAGE = "ansys-mapdl-reader"


def opened(path: Path, what: str, kinds: tuple[str, ...]) -> Any:
    """Return the reader of a binary file; `kinds` are the names of classes that will do.

    Raises InputError without the library, and for a file of another kind.
    """
    try:
        library = importlib.import_module("ansys.mapdl.reader")
    except ImportError as error:
        raise InputError(
            f"{path}: needs the Python package {PACKAGE} ({error}); "
            f"expected `pip install {PACKAGE}` (with VTK, 0.7 GB)"
        ) from error
    try:
        found = library.read_binary(str(path))
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"{path}: expected {what} of ANSYS ({error})") from error
    if type(found).__name__ not in kinds:
        raise InputError(f"{path}: expected {what} of ANSYS, found {type(found).__name__}")
    return found


def mesh_of(path: Path) -> tuple[IntArray, Array, Cells, Any]:
    """Return labels (n,), coordinates (n, 3), cells and the reader of a result file .rst.

    Raises InputError for a file of another kind, and nodes with axes of their own.
    """
    result = opened(path, "a result file .rst", ("Result",))
    mesh = result.mesh
    ids = np.asarray(mesh.nnum, dtype=np.int64)
    turned = np.flatnonzero(np.any(np.asarray(mesh.node_angles) != 0.0, axis=1))
    if len(turned):
        raise InputError(
            f"{path}: node {ids[turned[0]]} has axes of its own ({len(turned)} such nodes); "
            "expected NROTAT of none: displacements along the global axes"
        )
    return ids, np.asarray(mesh.nodes, dtype=float), _cells(result.grid, ids, path), result


def _cells(grid: Any, ids: IntArray, path: Path) -> Cells:
    """Cells of a VTK grid, whose points are labelled."""
    rows = rows_of(np.asarray(grid.point_data["ansys_node_num"], dtype=np.int64), ids, str(path))
    padded = np.asarray(grid.cells, dtype=np.int64)  # count, points, count, points, ...
    cells, types, at = [], [], 0
    for kind in np.asarray(grid.celltypes).tolist():
        count = int(padded[at])
        cells.append(rows[padded[at + 1 : at + 1 + count]].tolist())
        types.append(WITH_MIDSIDES.get((kind, count), kind))
        at += 1 + count
    return Cells.of(cells, types)
