"""Result files of a batch of analyses: one file for each specification."""

import dataclasses
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from ..solver.errors import InputError
from ..solver.package.fingerprint import has_fingerprint
from ..solver.package.section.schema import SectionFile
from ..solver.package.shell.schema import ShellFile

# Environment variables that the common MPI launchers set.
LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS")

Result = TypeVar("Result", SectionFile, ShellFile)


class Ranks(Protocol):
    """The processes that make one file together."""

    rank: int
    team: Any  # for `analyse`; None: one process

    def broadcast(self, value: Any) -> Any:
        """The value of rank 0."""

    def agree(self, error: BaseException | None) -> None:
        """Wait for the others; raises the first error of any of them."""


class Alone:
    """One process."""

    rank = 0
    team = None

    def broadcast(self, value: Any) -> Any:
        """The value itself."""
        return value

    def agree(self, error: BaseException | None) -> None:
        """No other process to wait for."""
        if error is not None:
            raise error


def launched_ranks() -> Ranks:
    """The ranks of this job; found without loading MPI where no launcher is at work."""
    if not any(name in os.environ for name in LAUNCHERS):
        return Alone()
    from .fenicsx import parallel

    ranks = parallel.Ranks()
    expected = os.environ.get("PLYMOTION_RANKS", "")
    if expected.isdecimal() and int(expected) != ranks.team.size:
        raise InputError(
            f"mpirun started {expected} processes, the MPI of this FEniCSx sees {ranks.team.size}: "
            f"expected the mpiexec of {sys.executable}"
        )
    return ranks


class AnalysedFiles(Generic[Result]):
    """Writes the results file of each specification.

    Parameters
    ----------
    ranks : processes that share the work on each file; only rank 0 writes
    progress : called with the name of each step of an analysis
    """

    def __init__(
        self, ranks: Ranks | None = None, progress: Callable[[str], None] | None = None
    ) -> None:
        self.ranks = ranks or Alone()
        self.progress = progress

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all inputs of a file."""
        raise NotImplementedError

    def analyse(self, spec: dict[str, Any], **team: Any) -> Result:
        """Results of a specification; `team` has the processes that share the work, if any."""
        raise NotImplementedError

    def write(self, target: Path, result: Result) -> None:
        """Write the file."""
        raise NotImplementedError

    def unchanged(self, target: Path, spec: dict[str, Any]) -> bool:
        """True if the target was made from the same inputs; the same on all ranks."""
        same = self.ranks.rank == 0 and has_fingerprint(target, self.fingerprint(spec))
        return bool(self.ranks.broadcast(same))

    def make(self, spec: dict[str, Any], target: Path) -> tuple[str, Sequence[dict[str, str]]]:
        """Analyse and write the file."""
        with self._together():
            result = self.analyse(spec, **({"team": self.ranks.team} if self.ranks.team else {}))
        with self._together():
            provenance = {**result.provenance, "fingerprint": self.fingerprint(spec)}
            result = dataclasses.replace(result, provenance=provenance)
            if self.ranks.rank == 0:
                self.write(target, result)
        return f"{result.provenance['dofs']} dofs", result.warnings

    @contextmanager
    def _together(self) -> Iterator[None]:
        """Work that ends on all ranks, or with the error of one on all of them."""
        failed: BaseException | None = None
        try:
            yield
        except Exception as error:
            failed = error
        self.ranks.agree(failed)
