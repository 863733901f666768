"""The command `plymotion run` with run files."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ...errors import InputError
from ...studies.exit_codes import worst
from ...studies.runs import run_files


def run_runs(options: argparse.Namespace) -> int:
    """Integrate the runs of run files; return the exit code of the worst."""
    files: list[Path] = options.files
    for name in ("run", "sweep", "packages", "coarse", "force", "no_report", "figures"):
        if getattr(options, name):
            raise InputError(f"--{name.replace('_', '-')}: expected with a case file only")
    if options.out is not None and len(files) > 1:
        raise InputError(f"--out {options.out}: expected with one run file only; use --out-dir")
    return integrated(files, options, options.jobs or 1, update=options.update)


def integrated(
    files: Sequence[Path], options: argparse.Namespace, jobs: int, *, update: bool
) -> int:
    """Integrate run files with the options of `run`; print what became of them."""
    outcomes = run_files(
        files,
        out=options.out if options.files == files else None,
        out_dir=options.out_dir,
        update=update,
        jobs=jobs,
        timing=options.timing,
        quiet=options.quiet,
        allow_python=options.allow_python,
        allow_doubtful=options.allow_doubtful,
    )
    codes = []
    for outcome in outcomes:
        for line in outcome.text:
            print(line, flush=True)
        for line in outcome.errors:
            print(f"error: {line}", file=sys.stderr, flush=True)
        codes.append(outcome.code)
    return worst(codes)
