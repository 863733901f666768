"""The sweeps of a case that a command was asked for."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..exit_codes import worst


def compute_sweeps(out: Path, names: Sequence[str], options: argparse.Namespace, jobs: int) -> int:
    """Compute sweeps whose bodies are built; return the worst exit code."""
    from ..sweep.command import run_sweep  # the solver takes 0.2 s to import

    codes = []
    for name in names:
        sweep = argparse.Namespace(
            sweep=out / "sweeps" / f"{name}.json",
            out=out / "sweeps" / name,
            jobs=jobs,
            executor=None,
            scheduler=None,
            shard=None,
            fresh=options.force,
            csv=False,
            figures=not options.no_report,
            quiet=options.quiet,
            allow_doubtful=options.allow_doubtful,
        )
        codes.append(run_sweep(sweep))
    return worst(codes)
