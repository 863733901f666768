"""The commands `check`, `run` and `report`: a case from its file to its report."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from ..errors import InputError, counted
from ..inputs.case.record import PackageEntry, case_file
from ..math.disk_cache import state_of, state_since
from ..package.common.files import RECORD as FILES
from ..studies.cases import (
    RECORD,
    build_folder,
    chosen_runs,
    chosen_sweeps,
    finished_before,
    folder_lock,
    note_finished,
    refuse_foreign_record,
    request_of,
)
from ..studies.exit_codes import INCOMPLETE, INPUT, worst
from ..system.interrupts import INTERRUPTED, stop_requested
from ..system.platform import cores
from .arguments import wanted_formats

# The sweeps of a case that a command was asked for.


def compute_sweeps(out: Path, names: Sequence[str], options: argparse.Namespace, jobs: int) -> int:
    """Compute sweeps whose bodies are built; return the worst exit code.

    Parameters
    ----------
    out : folder of the results of the case
    names : names of the sweeps
    options : parsed arguments of the command
    jobs : number of processes
    """
    from .sweep import run_sweep  # the solver takes 0.2 s to import

    own = {"jobs": jobs, "fresh": options.force, "figures": not options.no_report}
    absent = dict.fromkeys(("executor", "scheduler", "shard", "merge", "csv"))
    codes = []
    for name in names:
        folder = out / "sweeps" / name
        place = {"sweep": folder.with_suffix(".json"), "out": folder}
        codes.append(run_sweep(argparse.Namespace(**{**vars(options), **own, **absent, **place})))
    return worst(codes)


# `plymotion case.toml`: check the case, build its bodies, integrate its runs, write the report.

# What the results depend on, of the options of a command.
ASKED = ("run", "sweep", "coarse", "no_scripts", "no_report", "figures", "svg", "pdf")
TRUSTED = ("allow_python", "allow_doubtful")
OF_A_CASE = ("run", "sweep", "packages", "coarse", "force", "no_report", "figures", "svg", "pdf")

Say = Callable[[str], None]


def run_any(options: argparse.Namespace) -> int:
    """Take a case to its report, or integrate run files; return the worst exit code."""
    if any(file.suffix == ".toml" or file.is_dir() for file in options.files):
        return run_case(options)
    files: list[Path] = options.files
    for name in OF_A_CASE:
        if getattr(options, name):
            raise InputError(f"--{name.replace('_', '-')}: expected with a case file only")
    if options.out is not None and len(files) > 1:
        raise InputError(f"--out {options.out}: expected with one run file only; use --out-dir")
    return integrated(files, options, options.jobs or 1, update=options.update)


def run_case(options: argparse.Namespace) -> int:
    """Take a case from its file to its report, or to its sweeps; return the worst exit code.

    What is up to date by content is not done again.
    """
    file = case_file(options.files[0])
    if len(options.files) > 1:
        raise InputError(f"{file}: expected one case file, or run files only")
    for name, given in (("--out-dir", options.out_dir), ("--update", options.update)):
        if given:
            raise InputError(f"{name}: for run files; with a case file use --out and --force")
    out: Path = options.out or build_folder(file, coarse=options.coarse)
    words = {name: getattr(options, name) for name in (*ASKED, *TRUSTED)}
    request = request_of(file, {**words, "packages": str(options.packages or "")})
    with folder_lock(out):
        before = None if options.force else finished_before(out, request)
        if before is not None:
            code, text = before
            print(f"{text}: up to date\n", end="")  # one write: make runs several cases at once
            return code
        return _done(file, out, options, request)


def _done(file: Path, out: Path, options: argparse.Namespace, request: str) -> int:
    """Do all stages; return the exit code."""
    from ..inputs.case.load import load_case, source_files
    from ..inputs.case.write import MANIFEST, write_case
    from ..workers.packages import named_packages

    def say(text: str) -> None:
        """Report a stage, so that a long one is not silent."""
        if not options.quiet:
            print(f"{out}: {text}", file=sys.stderr, flush=True)

    refuse_foreign_record(out)  # before the work
    begin, inputs = time.time_ns(), {file: state_of(file)}
    case = load_case(file, coarse=options.coarse, sweeps=options.sweep or ())
    inputs |= {source: state_since(source, begin) for source in source_files(case)}
    runs, sweeps = chosen_runs(case, options.run), chosen_sweeps(case, options.sweep)
    if sweeps and not options.run:
        runs = []
    write_case(case, out, options.packages)
    jobs = options.jobs or cores()
    files = [out / "runs" / f"{run}.json" for run in runs]
    files += [out / "sweeps" / f"{sweep}.json" for sweep in sweeps]
    named = {each: named_packages(each) for each in files}
    if options.packages is None:
        _build(named, jobs, say, keep_going=not runs)
    used = [out / entry["file"] for entries in named.values() for entry in entries]
    inputs |= {package: state_of(package) for package in used}
    codes, text = [], ""
    if runs:
        code, text = _integrated(out, runs, options, jobs, say)
        codes.append(code)
    if sweeps and INTERRUPTED not in codes:
        say(f"sweeps: {', '.join(sweeps)}")
        codes.append(compute_sweeps(out, sweeps, options, jobs))
        text = text or str(out / "sweeps" / sweeps[0])
    code = worst(codes)
    if code in (0, INCOMPLETE):
        results = _results(out, runs, sweeps)
        note_finished(out, request, code, text, inputs, results, shared=(MANIFEST,))
    return code


def _build(
    named: Mapping[Path, Sequence[PackageEntry]],
    jobs: int,
    say: Say,
    *,
    keep_going: bool,
) -> None:
    """Build the bodies of run and sweep files; `keep_going` without those that cannot be built."""
    from ..workers.executors import Local
    from ..workers.packages import BodiesFailed, build_packages, needed_specs

    for folder, specs in needed_specs(named).items():
        say(f"bodies: {len(specs)}")
        try:
            if not build_packages(specs, folder, executor=lambda: Local(jobs, threads=True)):
                say("bodies: up to date")
        except BodiesFailed as error:
            if not keep_going:
                raise
            print(f"error: {error}", file=sys.stderr)


def _integrated(
    out: Path, runs: Sequence[str], options: argparse.Namespace, jobs: int, say: Say
) -> tuple[int, str]:
    """Integrate runs and write their report; return the exit code and what was written."""
    say(f"runs: {len(runs)}")
    files = [out / "runs" / f"{name}.json" for name in runs]
    code = integrated(files, options, jobs, update=not options.force)
    if code == INTERRUPTED or options.no_report:
        return code, str(out)
    if stop_requested():  # while the last run was written
        raise KeyboardInterrupt
    finished = [name for name in runs if (out / name / "summary.json").is_file()]
    if not finished:
        return code or INPUT, str(out)

    say("report")
    print(report_case(out, finished, figures=wanted_formats(options)))
    return code, str(out / "report.html")


def _results(out: Path, runs: Sequence[str], sweeps: Sequence[str]) -> Iterator[Path]:
    """Yield the files of a folder that a finished command has left or used."""
    folders = [out, out / "runs", out / "bodies", out / "plans", *(out / name for name in runs)]
    if sweeps:
        folders += [out / "sweeps", out / "sweeps/bodies", *(out / "sweeps" / s for s in sweeps)]
    for folder in folders:
        if folder.is_dir():
            yield from (
                file
                for file in folder.iterdir()
                if file.is_file() and file.name not in (RECORD, FILES)
            )


def integrated(
    files: Sequence[Path], options: argparse.Namespace, jobs: int, *, update: bool
) -> int:
    """Integrate run files with the options of `run`; print what became of them.

    Parameters
    ----------
    files : run files
    options : parsed arguments of the command
    jobs : number of processes
    update : leave out runs that are up to date
    """
    from ..studies.runs import run_files

    own = {name: getattr(options, name) for name in ("out_dir", "timing", "quiet", *TRUSTED)}
    out, codes = options.out if options.files == files else None, []
    outcomes = run_files(files, out=out, update=update, jobs=jobs, **own)
    for outcome in outcomes:
        for line in outcome.text:
            print(line, flush=True)
        for line in outcome.errors:
            print(f"error: {line}", file=sys.stderr, flush=True)
        codes.append(outcome.code)
    return worst(codes)


def run_check(options: argparse.Namespace) -> int:
    """Check a case file; with --out, write the input of the other commands."""
    from ..inputs.case.load import load_case, load_whole_case
    from ..inputs.case.write import write_case

    if options.reference:
        from ..inputs.manual import case_page

        print(case_page(), end="")
        return 0
    if options.case is None:
        raise InputError("check: no case file given; expected CASE.toml")
    file = options.case
    case = load_case(file, coarse=True) if options.coarse else load_whole_case(file)
    for name, study in case.studies.items():
        from ..studies.design.drivers.table import driver_of  # loads SciPy

        driver_of(study.table.driver, f"{file}: design.studies.{name}")
    if options.out is None:
        print(f"{file}: {counted(len(case.runs), 'run')}, no errors")
    else:
        write_case(case, options.out, options.packages)
    return 0


def run_report(options: argparse.Namespace) -> int:
    """Write the report of a folder and print the table of its runs."""
    if options.live:
        from ..studies.live import live_page

        for number, page in enumerate(live_page(options.folder)):
            if not number:
                print(f"{page}: open it in a browser; it follows the runs", flush=True)
        print(f"{options.folder}: the command there has ended")
        return 0
    figures = wanted_formats(options)
    print(report_case(options.folder, figures=figures, glb=options.glb, vtk=options.vtk))
    return 0


def report_case(
    folder: Path,
    runs: Sequence[str] | None = None,
    *,
    figures: Sequence[str] = (),
    glb: bool = False,
    vtk: bool = False,
) -> str:
    """Write report.html of a folder that `check` wrote; return a table of its runs.

    Parameters
    ----------
    runs : names of finished runs; None: all that have a summary
    figures : formats of the figures that are drawn too, of png, svg, pdf
    glb, vtk : write motion.glb, motion.vtkhdf of each run too

    Raises
    ------
    InputError
        Not the folder of a case; no finished run; figures without matplotlib.
    """
    from ..report.animation import write_glb, write_vtk
    from ..report.report_data import case_table
    from ..report.report_page import make_report
    from ..report.table import summary_table
    from ..results import read_result, read_summary

    try:
        case = case_table(json.loads((folder / "case.json").read_text(encoding="utf-8")))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(
            f"{folder}: no case.json ({getattr(error, 'strerror', None) or error}); expected the "
            "folder of a case, such as build/CASE"
        ) from error
    if runs is None:
        runs = [r for r in case["runs"] if (folder / r / "summary.json").is_file()]
    if not runs:
        raise InputError(f"{folder}: no finished run; expected <run>/summary.json")
    page = make_report(folder, list(runs), case, figures=bool(figures), formats=figures)
    summaries = [read_summary(folder / run / "summary.json") for run in runs]
    text = f"{summary_table(summaries)}\nReport: {page}"
    for run in runs:
        result = folder / run / "result.vtkhdf"
        if glb:
            text += f"\nAnimation: {write_glb(folder / run / 'motion.glb', read_result(result))}"
        if vtk:
            text += f"\nAnimation: {write_vtk(folder / run / 'motion.vtkhdf', result)}"
    return text
