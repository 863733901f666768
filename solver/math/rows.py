"""Long columns of numbers: as text, and as arrays in files, a block of rows at a time."""

import base64
import binascii
import bisect
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import IO, Any, ClassVar
from weakref import WeakSet

import numpy as np

from .arrays import Array, IntArray

PREFIX = "float64:"


class Packed(str):
    """A packed column, made here and not by a user."""

    __slots__ = ()


def packed(values: Array) -> Packed:
    """Return a column (k,) as text."""
    data = base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return Packed(PREFIX + data.decode("ascii"))


def column(values: Sequence[float] | str | None) -> Array:
    """Return the numbers of a column (k,); none of a column that is not given.

    Raises ValueError : text that is no packed column.
    """
    if not isinstance(values, str):
        return np.asarray([] if values is None else values, dtype=float)
    try:
        data = base64.b64decode(values.removeprefix(PREFIX), validate=True)
        return np.frombuffer(data, dtype="<f8")
    except (binascii.Error, ValueError) as error:
        raise ValueError(f"expected numbers, or a packed column ({error})") from error


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
            values = self._some(np.arange(first, end, step)) if step != 1 else self.read(first, end)
        elif np.ndim(rows) == 0:
            at = range(len(self))[int(rows)]
            return self.read(at, at + 1)[(0, *rest)]
        else:
            chosen = np.arange(len(self))[rows] if np.asarray(rows).dtype == bool else rows
            values = self._some(np.asarray(chosen, dtype=np.int64) % max(len(self), 1))
        return values[(slice(None), *rest)] if rest else values

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self.read(0, len(self)).astype(dtype or float, copy=False)

    def _some(self, rows: IntArray) -> Array:
        values = np.empty((len(rows), *self.shape[1:]))
        breaks = np.flatnonzero(np.diff(rows) != 1) + 1
        for part in np.split(np.arange(len(rows)), breaks):  # rows that follow each other
            if part.size:
                values[part] = self.read(int(rows[part[0]]), int(rows[part[-1]]) + 1)
        return values


def temporary_file(folder: Path | None) -> IO[bytes]:
    """Return a file without a name: the system removes it, whatever happens."""
    import tempfile  # most results are small

    return tempfile.TemporaryFile(dir=folder)


class StoredRows(LongRows):
    """Rows in a temporary file.

    Parameters
    ----------
    row : shape of a row
    place : folder of a new file, None: that of temporary files; or a file with other rows too
    """

    def __init__(self, row: tuple[int, ...], place: Path | IO[bytes] | None = None) -> None:
        self.shape = (0, *row)
        _STORED.add(self)
        self._file = temporary_file(place) if place is None or isinstance(place, Path) else place
        self._pieces: list[tuple[int, int]] = []  # first row, place in the file

    def append(self, rows: Array) -> None:
        """Add rows (k, ...)."""
        raw = np.ascontiguousarray(rows, dtype=float)
        if raw.size:
            self._pieces.append((len(self), self._file.seek(0, os.SEEK_END)))
            self._file.write(raw.data)
        self.shape = (len(self) + len(raw), *self.shape[1:])

    def cut(self, count: int) -> None:
        """Drop all rows but the first `count`."""
        self.shape = (min(count, self.shape[0]), *self.shape[1:])
        self._pieces = [piece for piece in self._pieces if piece[0] < count]

    def read(self, first: int, end: int) -> Array:
        """Return rows first to end - 1."""
        values = np.empty((max(end - first, 0), *self.shape[1:]))
        size, raw = 8 * int(np.prod(self.shape[1:])), values.reshape(-1).view(np.uint8)
        at = max(bisect.bisect_right(self._pieces, (first, np.inf)) - 1, 0)
        for (start, place), (last, _) in pairwise([*self._pieces[at:], (len(self), 0)]):
            if start >= end or first >= end:
                break
            a, b = max(first, start), min(end, last)
            self._file.seek(place + size * (a - start))
            self._file.readinto(raw[size * (a - first) : size * (b - first)].data)  # type: ignore[attr-defined]
        return values


_STORED: WeakSet[StoredRows] = WeakSet()


def reopen_stored() -> None:
    """Give a copy of a process (fork, Linux) its own place in files: both would move a common one.

    What it appends may lie under rows of the other process. These are the same: a copy is made
    between steps, and appends what both have.
    """
    for rows in _STORED:
        rows._file = open(f"/proc/self/fd/{rows._file.fileno()}", "r+b")  # noqa: SIM115


class ComputedRows(LongRows):
    """Rows that are computed when they are read, by a function of first and end."""

    def __init__(self, shape: tuple[int, ...], compute: Callable[[int, int], Array]) -> None:
        self.shape, self._compute = shape, compute

    def read(self, first: int, end: int) -> Array:
        """Return rows first to end - 1."""
        return self._compute(first, end)


class RowKeeper:
    """Rows that come in blocks, put together: in memory, or in a temporary file.

    Rows in memory are copies: a column alone would keep all columns of its array.
    """

    def __init__(self, file: IO[bytes] | None = None) -> None:
        self._file = file
        self._blocks: list[Array] = []
        self._rows: StoredRows | None = None

    def append(self, rows: Array) -> None:
        """Add rows (k, ...)."""
        if self._file is None:
            self._blocks.append(rows.copy())
            return
        if self._rows is None:
            self._rows = StoredRows(rows.shape[1:], self._file)
        self._rows.append(rows)

    def all(self) -> Any:
        """Return all rows: an array, or StoredRows."""
        if self._rows is not None:
            return self._rows
        if len(self._blocks) > 1:
            self._blocks = [np.concatenate(self._blocks)]
        return self._blocks[0]


def computed(like: Any, shape: tuple[int, ...], compute: Callable[[int, int], Array]) -> Any:
    """Return rows by a function of first and end: an array, or ComputedRows if `like` is long.

    Parameters
    ----------
    like : rows whose kind decides: an array, or LongRows of a file
    shape : shape of the result, rows first
    compute : function of first row and end
    """
    if isinstance(like, LongRows):
        return ComputedRows(shape, compute)
    parts = [compute(first, end) for first, end in spans(shape[0], int(np.prod(shape[1:])))]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def columns(rows: Any, first: int, end: int) -> Any:
    """Return columns first to end - 1 of rows (k, n): a view, or ComputedRows.

    Parameters
    ----------
    rows : array or LongRows (k, n)
    first : first column
    end : column after the last one
    """
    if not isinstance(rows, LongRows):
        return rows[:, first:end]
    return ComputedRows((len(rows), end - first), lambda a, b: rows.read(a, b)[:, first:end])
