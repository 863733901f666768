"""Bodies of the NASTRAN family: K and M in OUTPUT4 files, nodes in bulk data."""

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import IntArray
from ..free_body import DIRECTIONS, FreeBody
from ..from_matrices import free_body
from ..layups import Layups
from .bulk_data import bulk_cards, read_bulk_data
from .files import Files
from .op4 import read_op4
from .pcomp import read_layups

NAMES = {"stiffness": ("KGG", "KAA"), "mass": ("MGG", "MAA")}
NOTHING = 1e-12  # diagonal of a dof without stiffness and mass, relative to the largest


def read(files: Files) -> FreeBody:
    """Body from `bulk` (deck) and `matrices` (OUTPUT4 with KGG and MGG), or two files.

    The rows are those of all grid points in ascending order, six each. Dofs without stiffness and
    mass (drilling of flat shells, rotations of solids) are left out.

    Raises InputError for matrices of another size or other names.
    """
    files.only(("bulk",), ("matrices", "stiffness", "mass"))
    deck = files.path("bulk")
    cards = list(bulk_cards(deck))
    ids, nodes, cells = read_bulk_data(deck, cards)
    K, M = (_matrix(files, key) for key in ("stiffness", "mass"))
    for name, A in (("stiffness", K), ("mass", M)):
        if A.shape != (6 * len(ids), 6 * len(ids)):
            raise InputError(
                f"{files.where}: {name}: {A.shape[0]} x {A.shape[1]}, but {len(ids)} grid points "
                f"have {6 * len(ids)} degrees of freedom; expected KGG and MGG, which no support "
                "reduces"
            )
    dofs = np.column_stack([np.repeat(ids, 6), np.tile(np.arange(1, 7), len(ids))])
    kept = _used(K) | _used(M)
    dropped = np.flatnonzero(~kept)
    counts = {
        name: int(np.count_nonzero(dropped % 6 == k))
        for k, name in enumerate(DIRECTIONS)
        if np.count_nonzero(dropped % 6 == k)
    }
    notes = {**files.notes(), "degrees of freedom without stiffness and mass": counts}
    layups: Layups | str | None = read_layups(deck, cards, nodes, cells)
    if isinstance(layups, str):
        notes["ply stresses"] = f"none: {layups}"
        layups = None
    K, M = (A[kept][:, kept] for A in (K, M))
    return free_body(files.where, K, M, nodes, ids, dofs[kept], cells, notes=notes, layups=layups)


def _used(A: sp.csr_matrix) -> IntArray:
    largest = np.asarray(abs(A).max(axis=1).todense()).ravel()
    return np.asarray(largest > NOTHING * largest.max())


def _matrix(files: Files, key: str) -> sp.csr_matrix:
    path = files.path(key if key in files else "matrices")
    found = read_op4(path)
    for name in NAMES[key]:
        if name in found:
            A = found[name]
            one_triangle = not (sp.triu(A, 1).nnz and sp.tril(A, -1).nnz)
            # MYSTRAN writes form 1 and both triangles; others one triangle of form 6.
            return sp.csr_matrix(A + A.T - sp.diags(A.diagonal())) if one_triangle else A
    raise InputError(
        f"{path}: matrices {', '.join(found)}; expected {' or '.join(NAMES[key])} for {key}"
    )
