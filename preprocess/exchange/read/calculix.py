"""Solids of CalculiX: the deck, and the matrices of `*FREQUENCY, SOLVER=MATRIXSTORAGE`."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ..free_body import FreeBody
from ..from_matrices import free_body
from .abaqus_deck import SHELLS, SOLIDS, read_deck
from .files import Files, text_lines

BESIDE = {"stiffness": ".sti", "mass": ".mas", "dofs": ".dof"}


def read(files: Files) -> FreeBody:
    """Body from `deck` (.inp); .sti, .mas and .dof are beside it or given.

    Raises InputError for a deck with shells (CalculiX expands them to solids, so the labels of the
    matrices are ambiguous), or files that do not belong together.
    """
    files.only(("deck",), tuple(BESIDE))
    deck = read_deck(files.path("deck"))
    for label, (kind, _, _) in deck.elements.items():
        if kind not in SOLIDS:
            hint = 'import shells by their modes, from = "calculix-modes"'
            raise InputError(
                f"{deck.file}: element {label} of type {kind}: expected solids "
                f"({', '.join(SOLIDS)}){'; ' + hint if kind in SHELLS else ''}"
            )
    for key, suffix in BESIDE.items():
        if key not in files:
            files.table = {**files.table, key: str(Path(files.table["deck"]).with_suffix(suffix))}
    ids, nodes, cells, groups = deck.mesh()
    dofs = _dofs(files.path("dofs"))
    K, M = (_matrix(files.path(key), len(dofs)) for key in ("stiffness", "mass"))
    return free_body(files.where, K, M, nodes, ids, dofs, cells, groups=groups, notes=files.notes())


def _dofs(path: Path) -> IntArray:
    """Label of the node and direction of each row: lines such as `12.3`, read as text."""
    pairs = []
    for number, line in enumerate(text_lines(path), 1):
        node, dot, direction = line.strip().partition(".")
        if not (dot and node.isdecimal() and direction.isdecimal()):
            raise InputError(f"{path}:{number}: expected node.direction, found {line.strip()!r}")
        pairs.append((int(node), int(direction)))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _matrix(path: Path, size: int) -> sp.csr_matrix:
    """One triangle, counted from 1, as `row column value`; completed to the whole matrix."""
    try:
        table: Array = np.fromstring(path.read_text(), sep=" ").reshape(-1, 3)
    except ValueError as error:
        raise InputError(f"{path}: expected lines `row column value` ({error})") from error
    if not len(table):
        raise InputError(f"{path}: empty; did the analysis end without an error?")
    rows, columns = (table[:, k].astype(np.int64) - 1 for k in (0, 1))
    if max(rows.max(), columns.max()) >= size or min(rows.min(), columns.min()) < 0:
        raise InputError(
            f"{path}: row {max(rows.max(), columns.max()) + 1}, but the file of degrees of freedom "
            f"has {size} lines: do the files belong to one analysis?"
        )
    if (rows > columns).any() and (rows < columns).any():
        raise InputError(f"{path}: expected one triangle, found entries on both sides")
    one = sp.coo_matrix((table[:, 2], (rows, columns)), (size, size)).tocsr()
    return sp.csr_matrix(one + one.T - sp.diags(one.diagonal()))
