"""Section files as a product of the batch: one file for each specification, in the same folder."""

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

# Environment variables of the common MPI launchers.
LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS")


class Ranks(Protocol):
    """The processes that analyse one section together."""

    rank: int
    team: Any  # for `analyse`; None: one process

    def agreed(self, value: Any) -> Any:
        """The value of rank 0."""

    def together(self) -> None:
        """Wait for the other processes."""


class Alone:
    """One process."""

    rank = 0
    team = None

    def agreed(self, value: Any) -> Any:
        """The value itself."""
        return value

    def together(self) -> None:
        """Nothing to wait for."""


def launched_ranks() -> Ranks:
    """The ranks of this job; MPI is loaded only if a launcher started the process."""
    if not any(name in os.environ for name in LAUNCHERS):
        return Alone()
    from ..fenicsx import parallel

    return parallel.Ranks()


class SectionFiles:
    """Makes the section file of one specification.

    Parameters
    ----------
    estimate, accuracy : see `analyse`; they are inputs like the specification itself
    ranks : processes that work on each section together; only rank 0 writes
    progress : called with the name of each step of the analysis
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
        """Hash of all inputs of a section file."""
        options = {"estimate": self.estimate, "accuracy": self.accuracy}
        version = list(SECTION_FORMAT_VERSION)
        return fingerprint({"spec": spec, "options": options, "format": version})

    def unchanged(self, target: Path, spec: dict[str, Any]) -> bool:
        """True if the target was made from the same inputs; equal on all ranks."""
        same = self.ranks.rank == 0 and stored_fingerprint(target) == self.fingerprint(spec)
        return bool(self.ranks.agreed(same))

    def make(self, spec: dict[str, Any], target: Path) -> tuple[str, Sequence[dict[str, str]]]:
        """Analyse the section and write its file."""
        from .analysis import analyse  # here: loads FEniCSx only if needed

        try:
            section = analyse(
                spec,
                "section",  # equal on all ranks: it is part of the key of kept meshes
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
    """Fingerprint of the inputs stored in a file; None if it is not a file of this project.

    Only the header is read: a file gets its name only when it is complete.
    """
    try:
        with open_file(target, PackageError) as file:
            found = json.loads(get_text(file, "provenance", "{}")).get("fingerprint")
    except (PackageError, ValueError):
        return None
    return str(found)
