"""The command `shell` of the preprocessor."""

import argparse
from pathlib import Path

from ..analysed_files import launched_ranks
from ..batch import build_all
from ..reporting import build_from_stdin, reporter
from .batch import ShellFiles


def run_shells(options: argparse.Namespace) -> int:
    """Make the requested shell files; returns the exit code."""
    ranks = launched_ranks()
    out: Path | None = options.out
    with reporter(options.json, ranks.rank == 0) as (report, progress):
        product = ShellFiles(ranks, progress, verify=options.verify)

        def target_of(spec: Path) -> Path:
            folder: Path = options.out_dir or spec.parent
            return out or folder / f"{spec.stem}.vtkhdf"

        if options.specs == [Path("-")]:
            return build_from_stdin(product, target_of, force=options.force, report=report)
        return build_all(product, options.specs, target_of, force=options.force, report=report)
