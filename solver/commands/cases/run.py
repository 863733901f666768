"""The command `plymotion run` with run files."""

import argparse
from pathlib import Path

from ...errors import InputError
from ...studies.runs import run_files


def run_runs(options: argparse.Namespace) -> int:
    """Integrate the runs of run files; return the exit code of the worst."""
    files: list[Path] = options.files
    for name in ("run", "sweep", "packages", "coarse", "force", "no_report", "figures"):
        if getattr(options, name):
            raise InputError(f"--{name.replace('_', '-')}: expected with a case file only")
    if options.out is not None and len(files) > 1:
        raise InputError(f"--out {options.out}: expected with one run file only; use --out-dir")
    return run_files(
        files,
        out=options.out,
        out_dir=options.out_dir,
        update=options.update,
        jobs=options.jobs or 1,
        timing=options.timing,
        quiet=options.quiet,
        allow_python=options.allow_python,
        allow_doubtful=options.allow_doubtful,
    )
