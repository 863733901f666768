"""Tables of numbers whose rows have numbers of their own: nodes, cells, layers of other codes."""

from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray
from .records import Records


@dataclass(frozen=True)
class NumberedRows:
    """Rows in any order, with any numbers from 1, each once; `r` counts rows.

    Attributes
    ----------
    numbers : (r,) number of each row
    values : (r, n) what follows the number
    lines : (r,) line of the file
    """

    records: Records
    what: str
    numbers: IntArray
    values: Array
    lines: IntArray

    @classmethod
    def read(cls, records: Records, count: int, columns: int, what: str) -> "NumberedRows":
        """Read `count` rows of a number and `columns` others; `what` names one row."""
        table, lines = records.table(count, 1 + columns, f"the number and values of a {what}")
        given = table[:, 0]
        for row in np.flatnonzero((given != np.rint(given)) | (given < 1)):
            raise records.wrong(lines[row], given[row], f"the number of a {what}, from 1")
        numbers = given.astype(np.int64)
        order = np.argsort(numbers, kind="stable")
        for row in np.flatnonzero(np.diff(numbers[order]) == 0):
            raise InputError(
                f"{records.file}, line {lines[order[row + 1]]}: {what} {numbers[order[row]]} is "
                f"also in line {lines[order[row]]}"
            )
        return cls(records, what, numbers, table[:, 1:], lines)

    def rows_of(self, given: Array, lines: IntArray, what: str) -> IntArray:
        """Rows with given numbers, which `what` describes for messages."""
        order = np.argsort(self.numbers)
        place = np.searchsorted(self.numbers, given, sorter=order)
        rows = order[np.minimum(place, len(order) - 1)]
        for bad in np.flatnonzero(self.numbers[rows] != given):
            least, most = self.numbers.min(), self.numbers.max()
            gaps = " with gaps" if most - least >= len(self.numbers) else ""
            raise self.records.wrong(
                lines[bad], given[bad], f"{what}, one of the numbers {least} to {most}{gaps}"
            )
        return np.asarray(rows, dtype=np.int64)

    def in_order_of(self, others: "NumberedRows") -> "NumberedRows":
        """The same rows in the order of others with the same numbers."""
        rows = others.rows_of(self.numbers.astype(float), self.lines, f"a {others.what}")
        missing = np.setdiff1d(np.arange(len(others.numbers)), rows)
        if missing.size:
            raise InputError(
                f"{self.records.file}: {others.what} {others.numbers[missing[0]]}: expected its "
                f"{self.what}"
            )
        order = np.argsort(rows)
        return NumberedRows(
            self.records, self.what, self.numbers[order], self.values[order], self.lines[order]
        )
