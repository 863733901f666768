"""`plymotion case.toml`: check the case, build its bodies, integrate its runs, write the report."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ...errors import InputError, nearest
from ...inputs.case import load_case
from ...inputs.case.load import Case
from ...inputs.case.specs import write_case
from ...math.cores import cores
from ..run.command import INPUT, INTERRUPTED, run_files
from .packages import build_packages, specs_of
from .report import report_case


def run_case(options: argparse.Namespace) -> int:
    """Take a case from its file to its report; return the exit code of the worst run.

    What is up to date by content is not done again.
    """
    file: Path = options.files[0]
    if len(options.files) > 1:
        raise InputError(f"{file}: expected one case file, or run files only")
    for name, given in (("--out-dir", options.out_dir), ("--update", options.update)):
        if given:
            raise InputError(f"{name}: for run files; with a case file use --out and --force")
    case = load_case(file / "case.toml" if file.is_dir() else file, coarse=options.coarse)
    chosen = _chosen(case, options.run)
    out: Path = options.out or Path("build") / (case.name + ("-coarse" if options.coarse else ""))
    write_case(case, out, options.packages)
    say = _Stages(out, quiet=options.quiet)
    specs = specs_of(out, chosen) if options.packages is None else []
    if specs:
        say.begin(f"bodies: {len(specs)}")
        built = build_packages(specs, out / "bodies", quiet=options.quiet)
        if not built:
            say.note("up to date")
    say.begin(f"runs: {len(chosen)}")
    code = run_files(
        [out / "runs" / f"{name}.json" for name in chosen],
        update=not options.force,
        jobs=options.jobs or cores(),
        timing=options.timing,
        quiet=options.quiet,
        allow_python=options.allow_python,
        allow_doubtful=options.allow_doubtful,
    )
    if code == INTERRUPTED or options.no_report:
        return code
    finished = [name for name in chosen if (out / name / "summary.json").is_file()]
    if finished:
        say.begin("report")
        print(report_case(out, finished))
    elif code == 0:
        return INPUT
    return code


def _chosen(case: Case, names: Sequence[str] | None) -> list[str]:
    """Return the runs to do, in the order of the case."""
    for name in names or ():
        if name not in case.runs:
            raise InputError(f"--run {name}: {case.file} has no such run{nearest(name, case.runs)}")
    return [name for name in case.runs if not names or name in names]


class _Stages:
    """Words for each stage on standard error, so that a long one is not silent."""

    def __init__(self, out: Path, *, quiet: bool) -> None:
        self.out, self.quiet = out, quiet

    def begin(self, what: str) -> None:
        """Announce a stage."""
        self.note(f"{self.out}: {what}")

    def note(self, text: str) -> None:
        """Add a line."""
        if not self.quiet:
            print(text, file=sys.stderr, flush=True)
