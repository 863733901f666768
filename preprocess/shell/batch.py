"""Shell files as a product of the batch: one file for each specification, in the same folder."""

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ...solver.package.shell.io import write_shell
from ...solver.package.shell.schema import SHELL_FORMAT_VERSION
from ..fingerprint import fingerprint
from ..section.batch import Alone, Ranks, stored_fingerprint


class ShellFiles:
    """Makes the results file of one shell from its specification.

    Parameters
    ----------
    ranks : processes that work on each shell together; only rank 0 writes
    progress : called with the name of each step of the analysis
    """

    def __init__(
        self, ranks: Ranks | None = None, progress: Callable[[str], None] | None = None
    ) -> None:
        self.ranks = ranks or Alone()
        self.progress = progress

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all inputs of a shell file."""
        return fingerprint({"spec": spec, "format": list(SHELL_FORMAT_VERSION)})

    def unchanged(self, target: Path, spec: dict[str, Any]) -> bool:
        """True if the target was made from the same inputs; equal on all ranks."""
        same = self.ranks.rank == 0 and stored_fingerprint(target) == self.fingerprint(spec)
        return bool(self.ranks.agreed(same))

    def make(self, spec: dict[str, Any], target: Path) -> tuple[str, Sequence[dict[str, str]]]:
        """Analyse the shell and write its file."""
        from .analysis import analyse  # here: loads FEniCSx only if needed

        try:
            team = {"team": self.ranks.team} if self.ranks.team else {}
            shell = analyse(spec, "shell", progress=self.progress, **team)
            provenance = {**shell.provenance, "fingerprint": self.fingerprint(spec)}
            shell = dataclasses.replace(shell, provenance=provenance)
            if self.ranks.rank == 0:
                write_shell(target, shell)
        finally:
            self.ranks.together()
        return f"{shell.provenance['dofs']} dofs", shell.warnings
