"""Rows of numbers in a text file, read as Fortran's list-directed READ does.

Every read begins on a new line, skips empty ones, and ignores what follows the last number that it
needs. A read that needs more numbers goes on in the next line. Text after ! or # is a comment.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray

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
