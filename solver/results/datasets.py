"""Datasets of a result file: rows over time, in chunks of one column each."""

from collections.abc import Callable, Iterator

import h5py
import numpy as np

from ..math.arrays import Array, IntArray
from ..math.rows import LongRows
from ..package.common.container import set_text

LARGE = 1_000_000  # size in bytes above which an array is compressed
ROWS = 8192  # of a chunk; in bytes 64 KiB, at which a column compresses as well as in longer ones
BLOCK = 2_000_000  # bytes that are written together
# Level 1: the digits of a motion hardly compress, higher levels gain 1 % for a tenth of the time.
PACKED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def chunk_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return the shape of chunks: few columns and many rows, because a column is smooth in time.

    Rows of a chunk are written together, with all columns: HDF5 then compresses each chunk once.
    """
    width = int(np.prod(shape[1:]))
    rows = min(shape[0], ROWS, max(1, BLOCK // (8 * max(width, 1))))
    left = max(1, ROWS // max(rows, 1))  # columns
    columns = []
    for size in reversed(shape[1:]):
        columns.append(max(1, min(size, left)))
        left //= columns[-1]
    return (max(rows, 1), *reversed(columns))


def blocks(shape: tuple[int, ...]) -> Iterator[tuple[int, int]]:
    """Yield first and end of blocks of rows that are whole chunks."""
    rows = chunk_shape(shape)[0]
    rows *= max(1, BLOCK // (8 * rows * max(int(np.prod(shape[1:])), 1)))
    for first in range(0, shape[0], rows):
        yield first, min(first + rows, shape[0])


def read_array(dataset: h5py.Dataset) -> np.ndarray:
    """Return the content of a dataset, block by block: a signal counts between two of them."""
    if dataset.nbytes <= LARGE or not dataset.ndim:
        return np.asarray(dataset[()])
    found = np.empty(dataset.shape, dataset.dtype)
    for first, end in blocks(dataset.shape):
        found[first:end] = dataset[first:end]
    return found


class Datasets:
    """Arrays with unit, frame and meaning; what is written is kept for the checksum.

    Parameters
    ----------
    total : bytes that will be written, about
    told : called with the part of them that is

    Attributes
    ----------
    written : large arrays by the path of their dataset
    """

    def __init__(self, total: int = 1, told: Callable[[float], None] | None = None) -> None:
        self.written: dict[str, Array | IntArray | LongRows] = {}
        self._total, self._told, self._done = total, told, 0

    def _tell(self, size: int) -> None:
        self._done += size
        if self._told is not None:
            self._told(min(self._done / self._total, 1.0))

    def put(
        self,
        group: h5py.Group,
        name: str,
        values: Array | IntArray | LongRows,
        unit: str,
        frame: str,
        text: str,
    ) -> h5py.Dataset:
        """Write an array; a large one compressed, block by block."""
        if values.nbytes > LARGE:
            dataset = group.create_dataset(
                name, values.shape, values.dtype, chunks=chunk_shape(values.shape), **PACKED
            )
            for first, end in blocks(values.shape):
                dataset[first:end] = values[first:end]
                self._tell(values.nbytes * (end - first) // values.shape[0])
            self.written[dataset.name.lstrip("/")] = values
        else:
            dataset = group.create_dataset(name, data=np.asarray(values))
            self._tell(values.nbytes)
        for key, word in (("unit", unit), ("frame", frame), ("description", text)):
            set_text(dataset, key, word)
        return dataset
