"""Matrices of DMIG cards in NASTRAN bulk data."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp

from plymotion.preprocess.exchange.formats.nastran import bulk_cards, real
from plymotion.solver.errors import InputError
from plymotion.solver.math.arrays import IntArray

WHOLE, SYMMETRIC = 1, 6  # forms


def read_dmig(path: Path) -> dict[str, tuple[IntArray, sp.csr_matrix]]:
    """Labels (N, 2) of grid point and component (0: scalar point), and matrix, by name.

    Raises InputError for a matrix that is neither square nor symmetric, or is complex.
    """
    forms: dict[str, int] = {}
    entries: dict[str, list[tuple[tuple[int, int], tuple[int, int], float]]] = {}
    for card, fields in bulk_cards(path):
        if card != "DMIG":
            continue
        name = fields[0]
        if fields[1] == "0":
            forms[name] = int(fields[2])
            if forms[name] not in (WHOLE, SYMMETRIC) or fields[3] not in ("1", "2"):
                raise InputError(
                    f"{path}: DMIG {name}: form {fields[2]}, type {fields[3]}; expected a real "
                    "square or symmetric matrix"
                )
            entries[name] = []
            continue
        if name not in entries:
            raise InputError(f"{path}: DMIG {name}: expected its head (second field 0) first")
        column = int(fields[1]), int(fields[2] or 0)
        data = [text for text in fields[3:] if text]
        for place, direction, value in zip(data[::3], data[1::3], data[2::3], strict=True):
            row = int(place), int(direction)
            entries[name].append((row, column, real(value, path, card)))
    return {name: _matrix(found, forms[name]) for name, found in entries.items()}


def _matrix(
    entries: list[tuple[tuple[int, int], tuple[int, int], float]], form: int
) -> tuple[IntArray, sp.csr_matrix]:
    labels = sorted({label for row, column, _ in entries for label in (row, column)})
    number = {label: i for i, label in enumerate(labels)}
    rows = [number[row] for row, _, _ in entries]
    columns = [number[column] for _, column, _ in entries]
    values = [value for _, _, value in entries]
    one = sp.csr_matrix((values, (rows, columns)), (len(labels), len(labels)))
    if form == SYMMETRIC:
        one = sp.csr_matrix(one + one.T - sp.diags(one.diagonal()))
    return np.array(labels, dtype=np.int64).reshape(-1, 2), one
