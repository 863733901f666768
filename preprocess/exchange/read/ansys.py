"""Bodies of ANSYS: K and M of a .full file, nodes and cells of a result file .rst."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import DIRECTIONS, Cells, FreeBody
from ..from_matrices import free_body
from .ansys_library import mesh_of, opened
from .files import Files


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
    dofs, K, M = opened(path, "matrices .full", ("FullFile",)).load_km()
    return np.asarray(dofs, dtype=np.int64), sp.csr_matrix(K), sp.csr_matrix(M)


def body_of(
    files: Files,
    path: Path,
    found: tuple[IntArray, sp.csr_matrix, sp.csr_matrix],
    mesh: tuple[IntArray, Array, Cells],
) -> FreeBody:
    """Complete the matrices of `matrices`, and check that nothing was held.

    mesh : labels, coordinates, cells
    """
    dofs, K, M = found
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
