"""Mistakes of a case as messages: one for several runs, with the number that is far from others."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, few

EXTREME = 1e75  # its fourth power is the end of the floating point range
RIGID = "expected a flexible body, this one is rigid"
ERRORS = (ArithmeticError, np.linalg.LinAlgError)  # to which such numbers may lead


def out_of_range(where: str, mechanism: Any) -> str:
    """Return a message that names the number; nothing if all numbers are ordinary.

    Parameters
    ----------
    where : file, or sweep
    mechanism : as plain data
    """
    key, value = max(_numbers(mechanism), key=lambda item: abs(math.log10(abs(item[1]))))
    if 1.0 / EXTREME < abs(value) < EXTREME:
        return ""
    return (
        f"{where}: {key} = {value:g}: expected numbers whose powers and products are within "
        "floating point range (1e-308 to 1e308)"
    )


def _numbers(data: Any, way: tuple[str, ...] = ()) -> Iterator[tuple[str, float]]:
    """Yield key and value of all numbers but 0."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _numbers(value, (*way, key))
    elif isinstance(data, list | tuple):
        for i, value in enumerate(data):
            yield from _numbers(value, (*way, str(i)))
    elif isinstance(data, int | float) and not isinstance(data, bool) and data:
        yield ".".join(way), data


class Findings:
    """Messages of a case in the order in which they came.

    Parameters
    ----------
    file : of the case
    runs : variants by run
    """

    def __init__(self, file: Path, runs: Mapping[str, Sequence[str]]) -> None:
        self.file, self.runs = file, runs
        self._found: dict[str, list[str]] = {}  # message: runs that have it; none: the case

    def __bool__(self) -> bool:
        return bool(self._found)

    def add(self, lines: Iterable[str]) -> None:
        """Add messages on the case as a whole, which name the file."""
        for line in lines:
            self._found.setdefault(line, [])

    def of_run(self, run: str, lines: Iterable[str]) -> None:
        """Add messages on a run, which begin with the key."""
        for line in lines:
            self._found.setdefault(f"{self.file}: {line}", []).append(run)

    @contextmanager
    def of_sweep(self, key: str) -> Iterator[None]:
        """Add what is raised about a sweep or study; not what its run has as well."""
        known = {f"{self.file}: {key}{line.removeprefix(str(self.file))}" for line in self._found}
        try:
            yield
        except InputError as error:
            self.add(line for line in str(error).splitlines() if line not in known)

    def lines(self) -> list[str]:
        """Return one line for each; of some runs only, with the first of them."""
        return [line + self._where(line, runs) for line, runs in self._found.items()]

    def _where(self, line: str, runs: Sequence[str]) -> str:
        if not runs or len(set(runs)) == len(self.runs):
            return ""
        first = runs[0]
        text = f"run {first}"
        if variants := self.runs[first]:
            text += f", variant{'s' * (len(variants) > 1)} {', '.join(variants)}"
        if rest := [run for run in dict.fromkeys(runs) if run != first]:
            text += f"; also {few(rest)}"
        if line.endswith(RIGID):  # it is flexible in a run without this message
            text += "; a signal of a body that a variant replaces: [variants.NAME.signals]"
        return f" ({text})"
