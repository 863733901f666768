"""Shell results files: the command `shell` of the preprocessor, and batches."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ....solver.package.fingerprint import fingerprint
from ....solver.package.shell.io import write_shell
from ....solver.package.shell.schema import SHELL_FORMAT_VERSION, ShellFile
from ...analysed_files import AnalysedFiles, Ranks, launched_ranks
from ...batch import build_all
from ...reporting import build_from_stdin, reporter


class ShellFiles(AnalysedFiles[ShellFile]):
    """Writes the results file of each shell.

    Parameters
    ----------
    verify : of `analyse`; an input like the specification itself
    ranks, progress : see `AnalysedFiles`
    """

    def __init__(
        self,
        ranks: Ranks | None = None,
        progress: Callable[[str], None] | None = None,
        *,
        verify: bool = False,
    ) -> None:
        super().__init__(ranks, progress)
        self.verify = verify

    def fingerprint(self, spec: dict[str, Any]) -> str:
        """Hash of all inputs of a shell file."""
        options = {"options": {"verify": True}} if self.verify else {}
        return fingerprint({"spec": spec, "format": list(SHELL_FORMAT_VERSION), **options})

    def analyse(self, spec: dict[str, Any], **team: Any) -> ShellFile:
        """Analyse the shell."""
        from .analysis import analyse  # here: FEniCSx is loaded only where something is built

        return analyse(spec, "shell", verify=self.verify, progress=self.progress, **team)

    def write(self, target: Path, result: ShellFile) -> None:
        """Write the shell file."""
        write_shell(target, result)


def run_shells(options: argparse.Namespace) -> int:
    """Make the requested shell files; returns the exit code."""
    ranks = launched_ranks()
    out: Path | None = options.out
    # With names from standard input, each rank reports to the process that started it.
    first = ranks.rank == 0 or options.specs == [Path("-")]
    with reporter(options.json, first) as (report, progress):
        product = ShellFiles(ranks, progress, verify=options.verify)

        def target_of(spec: Path) -> Path:
            folder: Path = options.out_dir or spec.parent
            return out or folder / f"{spec.stem}.vtkhdf"

        if options.specs == [Path("-")]:
            return build_from_stdin(product, target_of, force=options.force, report=report)
        return build_all(product, options.specs, target_of, force=options.force, report=report)
