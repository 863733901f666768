"""Requested output times of a run, and the rows of its solution at them, in memory or in a file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...math.arrays import Array
from ...math.rows import IN_MEMORY, StoredRows

WINDOW = 16_000_000  # bytes of rows in memory if there are too many for it


class Output:
    """Rows of the requested times (k,).

    Integrators fill `rows` from `filled` on, at the times `window`. A full window goes to the file.

    Parameters
    ----------
    times : (k,) [s], ascending
    n : numbers in a row
    folder : for a file; None: that of temporary files
    """

    def __init__(self, times: Array, n: int, folder: Path | None = None) -> None:
        self.times = times
        self._stored: StoredRows | None = None
        room = times.size
        if 8 * n * times.size > IN_MEMORY:
            self._stored, room = StoredRows((n,), folder), max(WINDOW // (8 * n), 16)
        self.rows = np.empty((room, n))
        self.filled = 0

    @property
    def in_parts(self) -> bool:
        """Whether there are more times than rows in memory."""
        return self._stored is not None

    @property
    def kept(self) -> int:
        """Number of rows in the file."""
        return 0 if self._stored is None else len(self._stored)

    @property
    def count(self) -> int:
        """Number of rows filled, in memory and in the file."""
        return self.kept + self.filled

    @property
    def window(self) -> Array:
        """Times of `rows`, (w,)."""
        return self.times[self.kept : self.kept + len(self.rows)]

    @property
    def next_time(self) -> float:
        """First time that the window has no room for; infinite if there is none."""
        at = self.kept + len(self.rows)
        return float(self.times[at]) if at < self.times.size else np.inf

    def make_room(self) -> None:
        """Put a full window into the file, if more times follow."""
        if self._stored is not None and self.filled == len(self.rows):
            self._stored.append(self.rows)
            self.filled = 0

    def cut(self, count: int) -> None:
        """Drop all rows but the first `count`."""
        if self._stored is not None and count < len(self._stored):
            self._stored.cut(count)
        self.filled = max(min(self.filled, count - self.kept), 0)

    def all(self, *more: tuple[float, Array]) -> tuple[Array, Any]:
        """Return times (k,) and rows (k, n), an array or StoredRows; with one more where given."""
        t, rows = self.times[: self.count], self.rows[: self.filled]
        for t_more, y_more in more:
            t, rows = np.append(t, t_more), np.vstack((rows, y_more))
        if self._stored is None:
            return t, rows
        self._stored.append(rows)
        self.filled = 0
        return t, self._stored


def requested_times(t_out: Sequence[float] | Array, t0: float, t_end: float) -> Array:
    """Check the output times: (k,) ascending without repetition, inside [t0, t_end].

    Parameters
    ----------
    t_out : output times (k,) [s]
    t0 : start of the run [s]
    t_end : end of the run [s]

    Raises
    ------
    ValueError : not so; the message names the offending time
    """
    times = np.asarray(t_out, dtype=float)
    if times.ndim != 1 or times.size == 0:
        raise ValueError(f"t_out: expected a non-empty 1-D array of times, got {t_out!r}")
    backward = np.flatnonzero(~(np.diff(times) > 0))
    if backward.size:
        i = int(backward[0])
        raise ValueError(
            f"t_out: expected strictly ascending times, got {times[i]!r} s followed by "
            f"{times[i + 1]!r} s at position {i + 1}"
        )
    for value in (times[0], times[-1]):
        if not t0 <= value <= t_end:
            raise ValueError(f"t_out: expected times in [{t0!r}, {t_end!r}] s, got {value!r} s")
    return times
