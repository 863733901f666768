"""Edges of a table of cells, each once, and the sides of the cells that lie on them."""

from functools import cached_property

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import sides


class Edges:
    """Edges in ascending order of their nodes.

    Attributes
    ----------
    ends, owner : (s, 2), (s,) sides of all cells, cell after cell, and their cells
    number : (s,) edge of each side
    nodes : (e, 2) of each edge, ascending
    count : (e,) number of its cells
    """

    def __init__(self, cells: IntArray) -> None:
        self.ends, self.owner = sides(cells)
        self._step = int(cells.max(initial=0)) + 1
        self._keys, number = np.unique(self._key(self.ends), return_inverse=True)
        self.number: IntArray = number.ravel()
        self.nodes: IntArray = np.stack(np.divmod(self._keys, self._step), axis=1)
        self.count: IntArray = np.bincount(self.number, minlength=len(self._keys))

    @cached_property
    def shared(self) -> IntArray:
        """The sides of each edge of exactly two cells, (k, 2)."""
        order = np.argsort(self.number, kind="stable")
        first = np.cumsum(self.count) - self.count
        return np.asarray(order[first[self.count == 2][:, None] + np.arange(2)])

    def find(self, ends: IntArray) -> IntArray:
        """Edges with these nodes (k, 2) in any order, (k,); -1 where there is none."""
        key = self._key(ends)
        row = np.searchsorted(self._keys, key).clip(max=len(self._keys) - 1)
        return np.where(self._keys[row] == key, row, -1)

    def on(self, lines: IntArray) -> tuple[IntArray, IntArray]:
        """Pairs of a line of some nodes (l, 2), by its row, and a side of a cell there."""
        line = np.full(len(self._keys) + 1, -1)
        line[self.find(lines)] = np.arange(len(lines))
        line[-1] = -1
        row = line[self.number]
        found = np.flatnonzero(row >= 0)
        return row[found], found

    def sums(self, values: Array) -> Array:
        """Sums over the sides of each edge of values (s, ...), (e, ...)."""
        out = np.zeros((len(self._keys), *values.shape[1:]))
        np.add.at(out, self.number, values)
        return out

    def _key(self, ends: IntArray) -> IntArray:
        return np.asarray(np.sort(ends, axis=1) @ [self._step, 1])
