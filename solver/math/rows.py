"""Arrays of which the first axis is time, too long for memory: read a block of rows at a time."""

import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from .arrays import Array, IntArray

IN_MEMORY = 8_000_000  # bytes of states that are kept in memory; results need ten times as much
BLOCK = 2_000_000  # bytes of states that are evaluated together


def spans(count: int, width: int) -> Iterator[tuple[int, int]]:
    """Yield first and end of blocks of `count` rows of `width` numbers; one block if they fit."""
    rows = max(16, BLOCK // (8 * max(width, 1)))
    for first in range(0, count, rows):
        yield first, min(first + rows, count)


class LongRows(ABC):
    """Numbers of shape (k, ...) that are read by rows: with an index, a slice or an array of them.

    NumPy takes it for an array, but then all of it comes into memory.
    """

    shape: tuple[int, ...]
    dtype: ClassVar[Any] = np.dtype(float)

    @abstractmethod
    def read(self, first: int, end: int) -> Array:
        """Return rows first to end - 1."""

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def nbytes(self) -> int:
        """Size as an array."""
        return 8 * int(np.prod(self.shape))

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        rows, rest = (key[0], key[1:]) if isinstance(key, tuple) else (key, ())
        if isinstance(rows, slice):
            first, end, step = rows.indices(len(self))
            found = self._some(np.arange(first, end, step)) if step != 1 else self.read(first, end)
        elif np.ndim(rows) == 0:
            at = range(len(self))[int(rows)]
            return self.read(at, at + 1)[(0, *rest)]
        else:
            chosen = np.arange(len(self))[rows] if np.asarray(rows).dtype == bool else rows
            found = self._some(np.asarray(chosen, dtype=np.int64) % max(len(self), 1))
        return found[(slice(None), *rest)] if rest else found

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self.read(0, len(self)).astype(dtype or float, copy=False)

    def _some(self, rows: IntArray) -> Array:
        found = np.empty((len(rows), *self.shape[1:]))
        breaks = np.flatnonzero(np.diff(rows) != 1) + 1
        for part in np.split(np.arange(len(rows)), breaks):  # rows that follow each other
            if part.size:
                found[part] = self.read(int(rows[part[0]]), int(rows[part[-1]]) + 1)
        return found


class StoredRows(LongRows):
    """Rows in a temporary file without a name: the system removes it, whatever happens.

    Parameters
    ----------
    row : shape of a row
    folder : where the file is; None: that of temporary files
    """

    def __init__(self, row: tuple[int, ...], folder: Path | None = None) -> None:
        self.shape = (0, *row)
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - lives as long as the rows

    def append(self, rows: Array) -> None:
        """Add rows (k, ...)."""
        raw = np.ascontiguousarray(rows, dtype=float)
        self._file.seek(self.nbytes)
        self._file.write(raw.data)
        self.shape = (self.shape[0] + len(raw), *self.shape[1:])

    def cut(self, count: int) -> None:
        """Drop all rows but the first `count`."""
        self.shape = (min(count, self.shape[0]), *self.shape[1:])

    def read(self, first: int, end: int) -> Array:
        """Return rows first to end - 1."""
        found = np.empty((max(end - first, 0), *self.shape[1:]))
        self._file.seek(first * self.nbytes // max(self.shape[0], 1))
        self._file.readinto(found.reshape(-1).view(np.uint8).data)  # type: ignore[attr-defined]
        return found


class ComputedRows(LongRows):
    """Rows that are computed when they are read, by a function of first and end."""

    def __init__(self, shape: tuple[int, ...], compute: Callable[[int, int], Array]) -> None:
        self.shape, self._compute = shape, compute

    def read(self, first: int, end: int) -> Array:
        """Return rows first to end - 1."""
        return self._compute(first, end)


class RowKeeper:
    """Rows that come in blocks, put together: in memory, or in a temporary file."""

    def __init__(self, *, stored: bool, folder: Path | None = None) -> None:
        self._stored, self._folder = stored, folder
        self._blocks: list[Array] = []
        self._rows: StoredRows | None = None

    def append(self, rows: Array) -> None:
        """Add rows (k, ...)."""
        if not self._stored:
            self._blocks.append(rows)
            return
        if self._rows is None:
            self._rows = StoredRows(rows.shape[1:], self._folder)
        self._rows.append(rows)

    def all(self) -> Any:
        """Return all rows: an array, or StoredRows."""
        if self._rows is not None:
            return self._rows
        return self._blocks[0] if len(self._blocks) == 1 else np.concatenate(self._blocks)


def computed(like: Any, shape: tuple[int, ...], compute: Callable[[int, int], Array]) -> Any:
    """Return rows by a function of first and end: an array, or ComputedRows if `like` is long."""
    if isinstance(like, LongRows):
        return ComputedRows(shape, compute)
    parts = [compute(first, end) for first, end in spans(shape[0], int(np.prod(shape[1:])))]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def columns(rows: Any, first: int, end: int) -> Any:
    """Return columns first to end - 1 of rows (k, n): a view, or ComputedRows."""
    if not isinstance(rows, LongRows):
        return rows[:, first:end]
    return ComputedRows((len(rows), end - first), lambda a, b: rows.read(a, b)[:, first:end])
