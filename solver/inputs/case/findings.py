"""What is wrong with a case: a mistake that several runs share is one message."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from ...errors import few


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

    def of_sweep(self, key: str, lines: Iterable[str]) -> None:
        """Add messages on a sweep, which name file and sweep; not what its run has as well."""
        known = {f"{self.file}: {key}{line.removeprefix(str(self.file))}" for line in self._found}
        self.add(line for line in lines if line not in known)

    def lines(self) -> list[str]:
        """Return one line for each; of some runs only, with the first of them."""
        return [line + self._where(runs) for line, runs in self._found.items()]

    def _where(self, runs: Sequence[str]) -> str:
        if not runs or len(set(runs)) == len(self.runs):
            return ""
        first = runs[0]
        words = f"run {first}"
        if variants := self.runs[first]:
            words += f", variant{'s' * (len(variants) > 1)} {', '.join(variants)}"
        if rest := [run for run in dict.fromkeys(runs) if run != first]:
            words += f"; also {few(rest)}"
        return f" ({words})"
