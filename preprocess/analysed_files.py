"""Results of analyses as products of the batch: one specification, one file beside it."""

import dataclasses
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from ..solver.errors import PackageError
from ..solver.package.common.container import get_text, open_file
from ..solver.package.section.schema import SectionFile
from ..solver.package.shell.schema import ShellFile

# What the common MPI launchers tell the processes that they start.
LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS")

Result = TypeVar("Result", SectionFile, ShellFile)


class Ranks(Protocol):
    """The processes that make one file together."""

    rank: int
    team: Any  # for `analyse`; None: one process

    def agreed(self, value: Any) -> Any:
        """The value of rank 0."""

    def together(self) -> None:
        """Wait for the others."""


class Alone:
    """One process."""

    rank = 0
    team = None

    def agreed(self, value: Any) -> Any:
        """The value itself."""
        return value

    def together(self) -> None:
        """Nobody to wait for."""


def launched_ranks() -> Ranks:
    """The ranks of this job; found without loading MPI where no launcher is at work."""
    if not any(name in os.environ for name in LAUNCHERS):
        return Alone()
    from .fenicsx import parallel

    return parallel.Ranks()


class AnalysedFiles(Generic[Result]):
    """One specification becomes the file of its results.

    Parameters
    ----------
    ranks : who works on each file together; only rank 0 writes
    progress : called with words while one is analysed
    """

    def __init__(
        self, ranks: Ranks | None = None, progress: Callable[[str], None] | None = None
    ) -> None:
        self.ranks = ranks or Alone()
        self.progress = progress

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all that a file is made from."""
        raise NotImplementedError

    def analyse(self, spec: dict[str, Any], **team: Any) -> Result:
        """Results of a specification; `team` has the processes that share the work, if any."""
        raise NotImplementedError

    def write(self, target: Path, result: Result) -> None:
        """Write the file."""
        raise NotImplementedError

    def unchanged(self, target: Path, spec: dict[str, Any]) -> bool:
        """True if the target was made from these very inputs; the same on all ranks."""
        same = self.ranks.rank == 0 and stored_fingerprint(target) == self.fingerprint(spec)
        return bool(self.ranks.agreed(same))

    def make(self, spec: dict[str, Any], target: Path) -> tuple[str, Sequence[dict[str, str]]]:
        """Analyse and write the file."""
        try:
            result = self.analyse(spec, **({"team": self.ranks.team} if self.ranks.team else {}))
            provenance = {**result.provenance, "fingerprint": self.fingerprint(spec)}
            result = dataclasses.replace(result, provenance=provenance)
            if self.ranks.rank == 0:
                self.write(target, result)
        finally:
            self.ranks.together()
        return f"{result.provenance['dofs']} dofs", result.warnings


def stored_fingerprint(target: Path) -> str | None:
    """What one of our files says that it was made from; None if it is no such file.

    Only the header is read: the file took its name when it was complete.
    """
    try:
        with open_file(target, PackageError) as file:
            found = json.loads(get_text(file, "provenance", "{}")).get("fingerprint")
    except (PackageError, ValueError):
        return None
    return str(found)
