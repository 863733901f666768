"""Bodies of ANSYS: K and M of a .full file, nodes, cells and modes of a result file .rst.

The library that reads its binary files is optional, found when a file asks for it.
"""

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import DIRECTIONS, Cells, FreeBody, ModalBody, free_body, rows_of
from ..import_table import Files

# The library gives elements with midside nodes the VTK type of those without.
WITH_MIDSIDES = {(12, 20): 25, (10, 10): 24, (13, 15): 26, (14, 13): 27, (9, 8): 23, (5, 6): 22}
PACKAGE = "ansys-mapdl-reader"
RIGID = 1e-3  # frequency of a rigid motion, relative to the highest in the file


def _opened(path: Path, what: str, kinds: tuple[str, ...]) -> Any:
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
        binary = library.read_binary(str(path))
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"{path}: expected {what} of ANSYS ({error})") from error
    if type(binary).__name__ not in kinds:
        raise InputError(f"{path}: expected {what} of ANSYS, found {type(binary).__name__}")
    return binary


def mesh_of(path: Path) -> tuple[IntArray, Array, Cells, Any]:
    """Return labels (n,), coordinates (n, 3), cells and the reader of a result file .rst.

    Raises InputError for a file of another kind, and nodes with axes of their own.
    """
    result = _opened(path, "a result file .rst", ("Result",))
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


def read(files: Files) -> FreeBody:
    """Body from `full` and `rst` of one analysis of the free body.

    Raises InputError without the library, for matrices of a held body, and for degrees of freedom
    that are no displacements.
    """
    files.only(("full", "rst"))
    path = files.path("full")
    dofs, K, M = matrices(path)
    ids, nodes, cells, _ = mesh_of(files.path("rst"))
    return body_of(files, path, (dofs, K, M), (ids, nodes, cells))


def matrices(path: Path) -> tuple[IntArray, sp.csr_matrix, sp.csr_matrix]:
    """Return node and direction (from 0) of each row, (N, 2), and the upper triangles of K and M.

    Raises InputError without the library, and for a file of another kind.
    """
    dofs, K, M = _opened(path, "matrices .full", ("FullFile",)).load_km()
    return np.asarray(dofs, dtype=np.int64), sp.csr_matrix(K), sp.csr_matrix(M)


def body_of(
    files: Files,
    path: Path,
    matrices: tuple[IntArray, sp.csr_matrix, sp.csr_matrix],
    mesh: tuple[IntArray, Array, Cells],
) -> FreeBody:
    """Complete the triangles of the matrices, and check that nothing was held.

    Parameters
    ----------
    files : of the import file, for messages and provenance
    path : file of the matrices, for messages
    matrices : as of `matrices`
    mesh : labels (n,), coordinates (n, 3), cells

    Raises
    ------
    InputError
        Held degrees of freedom, or some that are no displacements.
    """
    dofs, K, M = matrices
    others = np.flatnonzero((dofs[:, 1] < 0) | (dofs[:, 1] >= len(DIRECTIONS)))
    if len(others):
        raise InputError(
            f"{path}: node {dofs[others[0], 0]} has degrees of freedom that are no displacements; "
            "expected a structural analysis"
        )
    # Rows of held dofs are there, but empty: their stiffness and mass were taken out.
    empty = np.flatnonzero((np.diff(K.indptr) == 0) & (K.diagonal() == 0.0))
    empty = empty[np.asarray(abs(K[:, empty]).sum(axis=0)).ravel() == 0.0]
    if len(empty):
        node, direction = dofs[empty[0]]
        raise InputError(
            f"{path}: {len(empty)} degrees of freedom are held, first node {node}, direction "
            f"{DIRECTIONS[direction]}, and their mass is lost; expected matrices of the free body: "
            "a modal analysis without supports, MODOPT of six more modes"
        )
    K, M = (sp.csr_matrix(A + A.T - sp.diags(A.diagonal())) for A in (K, M))
    ids, nodes, cells = mesh
    numbers = np.column_stack([dofs[:, 0], dofs[:, 1] + 1])
    return free_body(files.where, K, M, nodes, ids, numbers, cells, notes=files.notes())


def read_modes(files: Files) -> ModalBody:
    """Body from `rst` and `masses` (CSV: node, mass and inertias).

    Rigid motions of a free body are left out.

    Raises InputError without the library, and for a file without modes of all nodes.
    """
    files.only(("rst", "masses"))
    path = files.path("rst")
    ids, nodes, cells, result = mesh_of(path)
    hertz = np.asarray(result.time_values, dtype=float)
    kept = np.flatnonzero(hertz > RIGID * hertz.max(initial=0.0))
    if not len(kept):
        raise InputError(f"{path}: expected vibrations of a modal analysis")
    kept = kept[np.argsort(hertz[kept], kind="stable")]
    shapes = np.zeros((len(kept), len(nodes), 6))
    size = 0
    for shape, number in zip(shapes, kept, strict=True):
        labels, values = result.nodal_solution(int(number))
        size = values.shape[1]
        if size not in (3, 6) or not np.array_equal(labels, ids) or np.isnan(values).any():
            raise InputError(
                f"{path}: mode {number + 1}: expected 3 or 6 displacements at each of the "
                f"{len(ids)} nodes"
            )
        shape[:, :size] = values
    return ModalBody(files.where, nodes, ids, cells, shapes, hertz[kept], size == 6)
