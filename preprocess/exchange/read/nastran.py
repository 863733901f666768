"""Bodies of the NASTRAN family: K and M in OUTPUT4 files, nodes in bulk data."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ....solver.errors import InputError
from ....solver.math.arrays import IntArray
from ..free_body import DIRECTIONS, FreeBody
from ..from_matrices import free_body
from ..layups import Layups
from .bulk_data import bulk_cards, read_bulk_data
from .files import Files
from .pcomp import read_layups

DOUBLE = {1: "f4", 2: "f8"}  # type of the matrix -> its numbers; complex ones are refused
DIAGONAL, SYMMETRIC = 3, 6  # forms
HEADER = (24, 32)  # bytes: name of 8 characters, or two words of a 64-bit writer


def read_op4(path: Path) -> dict[str, sp.csr_matrix]:
    """Matrices by name. A form "symmetric" still holds both triangles, or only one: see `K`, `M`.

    Raises InputError for a file that ends early or holds complex matrices.
    """
    data = path.read_bytes()
    order = "<" if data[:4] != b"" and int.from_bytes(data[:4], "little") in HEADER else ">"
    found: dict[str, sp.csr_matrix] = {}
    records = _records(data, order, path)
    for record in records:
        columns, rows, _, kind = np.frombuffer(record[:16], f"{order}i4").tolist()
        name = record[16:24].decode("ascii", "replace").strip()
        if kind not in DOUBLE:
            raise InputError(f"{path}: matrix {name} has the type {kind}: expected a real one")
        if not max(abs(rows), columns) <= len(data):  # every row of a body has a number
            raise InputError(
                f"{path}: matrix {name}: {abs(rows)} x {columns} in a file of {len(data)} bytes: "
                "expected a matrix with at least one number in each row"
            )
        number = np.dtype(f"{order}{DOUBLE[kind]}")
        entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        for column in records:
            at, first, _ = np.frombuffer(column[:12], f"{order}i4").tolist()
            if at > columns:
                break
            for row, values in _strings(column[12:], first, number, order):
                used = np.flatnonzero(values)
                entries.append((row - 1 + used, np.full(len(used), at - 1), values[used]))
        else:
            raise InputError(f"{path}: matrix {name}: the file ends before its last column")
        joined = [np.concatenate(part) for part in zip(*entries, strict=True)] if entries else None
        shape = (abs(rows), columns)
        if joined is None:
            found[name] = sp.csr_matrix(shape)
        else:
            found[name] = sp.csr_matrix((joined[2].astype(float), (joined[0], joined[1])), shape)
    if not found:
        raise InputError(f"{path}: no matrix; expected a binary OUTPUT4 file")
    return found


def _records(data: bytes, order: str, path: Path) -> Iterator[bytes]:
    """Records of a Fortran file: length, bytes, length."""
    place = 0
    while place < len(data):
        size = int(np.frombuffer(data[place : place + 4], f"{order}i4")[0])
        end = place + 4 + size
        if size < 0 or data[end : end + 4] != data[place : place + 4]:
            raise InputError(f"{path}: damaged at byte {place}; expected a binary OUTPUT4 file")
        yield data[place + 4 : end]
        place = end + 4


def _strings(
    data: bytes, first: int, number: np.dtype, order: str
) -> Iterator[tuple[int, np.ndarray]]:
    """First row and values of each string of a column.

    A dense column is one string. A sparse one (first = 0) has a word before each: its length in
    words plus one, times 65536, plus its first row.
    """
    if first > 0:
        yield first, np.frombuffer(data[: len(data) // number.itemsize * number.itemsize], number)
        return
    place = 0
    while place + 4 <= len(data):
        word = int(np.frombuffer(data[place : place + 4], f"{order}i4")[0])
        size, row = word // 65536 - 1, word % 65536
        if size <= 0:
            return
        place += 4
        yield row, np.frombuffer(data[place : place + 4 * size], number)
        place += 4 * size


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
