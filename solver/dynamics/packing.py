"""Lists of arrays as one flat array with starts: the form of `Model`."""

from collections.abc import Sequence

import numpy as np

from ..math.arrays import Array


def filled(lists: Sequence[Sequence[float]], columns: int) -> Array:
    """Return lists of numbers as rows (n, columns), filled up with zeros."""
    out = np.zeros((len(lists), columns))
    for row, numbers in zip(out, lists, strict=True):
        row[: len(numbers)] = numbers
    return out


def pairs(markers: list[tuple[int, int]]) -> np.ndarray:
    """Return pairs of markers as rows (n, 2)."""
    return np.array(markers, dtype=np.int64).reshape(-1, 2)


def starts(sizes: np.ndarray) -> np.ndarray:
    """Return where parts of these sizes (n,) begin, and the end of the last: (n + 1,)."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def stack(arrays: list[Array], shape: tuple[int, ...]) -> Array:
    """Return arrays of one shape as one array (n, *shape)."""
    return np.ascontiguousarray(np.array(arrays, dtype=float).reshape(-1, *shape))


def flat(arrays: list[Array]) -> Array:
    """Return the entries of all arrays, one array after the other."""
    if not arrays:
        return np.zeros(0)
    return np.concatenate([np.ascontiguousarray(a, dtype=float).reshape(-1) for a in arrays])
