"""Section files as a product of the batch: one specification, one file beside it."""

import dataclasses
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

from ...solver.errors import PackageError
from ...solver.package.common.container import get_text, open_file
from ...solver.package.section.io import write_section
from ...solver.package.section.schema import SECTION_FORMAT_VERSION
from ..fingerprint import fingerprint

# What the common MPI launchers tell the processes that they start.
LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS")


class Ranks(Protocol):
    """The processes that make one section together."""

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
    from ..fenicsx import parallel

    return parallel.Ranks()


class SectionFiles:
    """One section's specification becomes its section file.

    Parameters
    ----------
    estimate, accuracy : of `analyse`; they are inputs like the specification itself
    ranks : who works on each section together; only rank 0 writes
    progress : called with words while a section is analysed
    """

    def __init__(
        self,
        *,
        estimate: bool = True,
        accuracy: float | None = None,
        ranks: Ranks | None = None,
        progress: Callable[[str], None] | None = None,
    ) -> None:
        self.estimate = estimate
        self.accuracy = accuracy
        self.ranks = ranks or Alone()
        self.progress = progress

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all that a section file is made from."""
        options = {"estimate": self.estimate, "accuracy": self.accuracy}
        version = list(SECTION_FORMAT_VERSION)
        return fingerprint({"spec": spec, "options": options, "format": version})

    def unchanged(self, target: Path, spec: dict[str, Any]) -> bool:
        """True if the target was made from these very inputs; the same on all ranks."""
        same = self.ranks.rank == 0 and stored_fingerprint(target) == self.fingerprint(spec)
        return bool(self.ranks.agreed(same))

    def make(self, spec: dict[str, Any], target: Path) -> tuple[str, Sequence[dict[str, str]]]:
        """Analyse the section and write its file."""
        from .analysis import analyse  # here: FEniCSx is loaded only where something is built

        try:
            section = analyse(
                spec,
                "section",  # the same for all: it is part of what finds a mesh that is kept
                estimate=self.estimate,
                accuracy=self.accuracy,
                progress=self.progress,
                **({"team": self.ranks.team} if self.ranks.team else {}),
            )
            provenance = {**section.provenance, "fingerprint": self.fingerprint(spec)}
            section = dataclasses.replace(section, provenance=provenance)
            if self.ranks.rank == 0:
                write_section(target, section)
        finally:
            self.ranks.together()
        return _summary(section.provenance), section.warnings


def _summary(provenance: dict[str, Any]) -> str:
    return f"{provenance['dofs']} dofs"


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
