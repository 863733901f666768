"""Rows of numbers in files of other codes."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....errors import InputError
from ....math.arrays import Array, IntArray

# Rows of numbers in a text file, read as Fortran's list-directed READ does.
#
# Every read begins on a new line, skips empty ones, and ignores what follows the last number that
# it needs. A read that needs more numbers goes on in the next line. Text after ! or # is a
# comment.

REPEATED = re.compile(r"(\d+)\*(\S+)")
NO_LETTER = re.compile(r"([0-9.])([+-]\d+)$")  # 1.5-3 is 1.5e-3
TO_EXPONENT = str.maketrans("dDqQ", "eeee")


class Records:
    """The lines of a file with numbers, and the place of the next read."""

    def __init__(self, file: Path) -> None:
        self.file = file
        try:
            text = file.read_text(encoding="utf-8-sig", errors="replace")
        except OSError as error:
            raise InputError(f"{file}: cannot be read: {error}") from error
        self._lines: list[int] = []
        self._words: list[list[str]] = []
        self.place = 0
        for number, line in enumerate(text.splitlines(), start=1):
            for comment in "!#":
                line = line.split(comment, 1)[0]
            words = line.replace(",", " ").split()
            if words and words != ["\x1a"]:  # the end of a file of DOS
                self._lines.append(number)
                self._words.append(words)

    @property
    def line(self) -> int:
        """Line of the file where the last read ended."""
        return self._lines[self.place - 1] if self.place else 0

    def words(self) -> list[str]:
        """Words of the line of the next read; none at the end of the file."""
        return self._words[self.place] if self.place < len(self._words) else []

    def reals(self, count: int, what: str) -> list[float]:
        """The numbers of one read."""
        found: list[float] = []
        while len(found) < count:
            if self.place >= len(self._words):
                raise InputError(f"{self.file}: the file ends before {what}")
            words = self._words[self.place]
            self.place += 1
            for word in words:
                repeat = REPEATED.fullmatch(word)
                times, text = (int(repeat[1]), repeat[2]) if repeat else (1, word)
                found += [self._real(text, what)] * min(times, count)
                if len(found) >= count:
                    break
        return found[:count]

    def whole(self, what: str, least: int = 0, most: int | None = None) -> int:
        """A read of one whole number within bounds."""
        return self.wholes([what], least, most)[0]

    def wholes(self, whats: Sequence[str], least: int = 0, most: int | None = None) -> list[int]:
        """Whole numbers within bounds of one read; `whats` says what each one is."""
        values = self.reals(len(whats), ", ".join(whats))
        limit = f" up to {most}" if most is not None else ""
        for what, value in zip(whats, values, strict=True):
            if value != int(value) or value < least or (most is not None and value > most):
                raise self.wrong(self.line, value, f"{what}, a whole number from {least}{limit}")
        return [int(value) for value in values]

    def wrong(self, line: int, value: float, what: str) -> InputError:
        """The error for a number of a line."""
        return InputError(f"{self.file}, line {line}: {value:g}: expected {what}")

    def table(self, rows: int, columns: int, what: str) -> tuple[Array, IntArray]:
        """The numbers of equal reads, (rows, columns), and the line of each."""
        start = self.place
        words = self._words[start : start + rows]
        if len(words) == rows and all(len(row) >= columns for row in words):
            try:
                text = np.array([row[:columns] for row in words])
                values = np.char.replace(np.char.lower(text), "d", "e").astype(float)
            except ValueError:
                values = np.full((rows, columns), np.nan)
            if np.isfinite(values).all():
                self.place += rows
                return values, np.array(self._lines[start : start + rows])
        values, lines = np.empty((rows, columns)), np.empty(rows, dtype=np.int64)
        for row in range(rows):
            values[row] = self.reals(columns, what)
            lines[row] = self.line
        return values, lines

    def _real(self, word: str, what: str) -> float:
        text = NO_LETTER.sub(r"\1e\2", word.translate(TO_EXPONENT))
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputError(f"{self.file}, line {self.line}: {word!r}: expected {what}")
        return value


# Tables of numbers whose rows have numbers of their own: nodes, cells, layers of other codes.


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
