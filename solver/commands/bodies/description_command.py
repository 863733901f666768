"""What `section`, `shell` and `solid` share: a results file for each description."""

import argparse
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...report.table import json_text
from ...system.interrupts import INTERRUPTED
from ...workers.description_results import (
    Entry,
    Made,
    Request,
    SpecOf,
    made_files,
    make_files,
    write_specs,
)
from ...workers.executors import executor_of
from ...workers.launch import kept_preprocessors, mpi_job
from ..arguments import FOLDERS
from ..heartbeat import Heartbeat

# What is shown of results files: numbers or JSON, failures, names of files.

USER_ERROR = 2
Shown = Callable[[list[Made], list[Request]], int]


def show_each(
    made: Sequence[Made],
    table_of: Callable[[Made], Any],
    text_of: Callable[[Made], str],
    *,
    as_json: bool,
) -> int:
    """Show one after the other, as text or as one JSON table; returns the exit code.

    Parameters
    ----------
    made : results files, and failures
    table_of : returns the table of one for --json
    text_of : returns the text of one
    as_json : print one JSON table
    """
    tables: dict[str, object] = {}
    code = 0
    for one in made:
        if one.status == "failed":
            code = USER_ERROR
            tell_failure(one)
            tables[one.entry.name] = {"error": one.error}
        elif as_json:
            tables[one.entry.name] = table_of(one)
        else:
            print(text_of(one), end="\n" if one is made[-1] else "\n\n")
    if as_json and not (code and len(made) == 1):
        print(json_text(next(iter(tables.values())) if len(made) == 1 else tables))
    return code


def tell_failure(one: Made) -> None:
    """Say on standard error why a file has not been made."""
    if one.defect:
        print(one.defect, end="", file=sys.stderr)
        print("this is a defect of the preprocessor, not of the input:", file=sys.stderr)
    for line in one.error.splitlines():  # keys as they are in the file, not in that of a body
        print(f"error: {re.sub(': (section|shell)[.]', ': ', line, count=1)}", file=sys.stderr)


def file_lines(one: Made, figures: Iterable[Path]) -> str:
    """Names of a results file and its figures."""
    note = " (unchanged)" if one.status == "unchanged" else ""
    first = f"{'Files':16}{one.file}{note}"
    return "\n".join([first, *(f"{'':16}{figure}" for figure in figures)])


def drawn(draw: Callable[[], list[Path]], known: Sequence[Path], file: Path) -> list[Path]:
    """Return the figures of a file: those that are there if none is older, else drawn again.

    Parameters
    ----------
    known : figures that are there, or should be
    """
    made = file.stat().st_mtime
    if known and all(figure.is_file() and figure.stat().st_mtime >= made for figure in known):
        return list(known)
    try:
        return draw()
    except (InputError, ModuleNotFoundError) as error:  # the numbers are still there
        print(f"no figures: {error}; they need pip install matplotlib", file=sys.stderr)
        return []


# From descriptions to results files, with progress on the screen.


def run_described(
    command: str,
    entries: Sequence[Entry],
    options: argparse.Namespace,
    words: Sequence[str],
    *,
    spec_of: SpecOf,
    show: Shown,
    list_each: bool = False,
) -> int:
    """Make what is described and show it; returns the exit code.

    Parameters
    ----------
    command, words : of the preprocessor: its command, `section` or `shell`, and options
    entries : results files among them are only shown
    options : out (default: FOLDERS), check, json, quiet, and those of the executor
    spec_of : checks a description and returns its specification
    show : what to do with the results, in the order of the entries; returns the exit code
    list_each : a line for each on standard error where there is no progress bar
    """
    elsewhere = options.executor or options.scheduler or options.check
    rank, ranks = (0, 1) if elsewhere else mpi_job()
    if ranks > 1 and options.jobs:
        raise InputError(f"--jobs {options.jobs}: expected without mpirun, whose ranks share each")
    if rank:
        return _join(command, entries, words, spec_of, ranks)
    options.out = options.out or FOLDERS[command]
    made: dict[str, Made] = {}
    try:
        made |= {e.name: Made(e, e.file, "unchanged") for e in entries if _is_result(e)}
        described = [entry for entry in entries if entry.name not in made]
        requests, failed = write_specs(described, options.out, spec_of)
        made |= {one.entry.name: one for one in failed}
        with kept_preprocessors() if ranks > 1 else nullcontext():
            if not options.check:
                with _Bar(command, made, len(entries), options.quiet, list_each) as bar:
                    make_files(
                        requests,
                        command,
                        words,
                        executor=lambda: executor_of(options, threads=True),
                        done=bar.done,
                        progress=bar.progress,
                        ranks=ranks,
                    )
            code = show([made[entry.name] for entry in entries if entry.name in made], requests)
            sys.stdout.flush()
    except KeyboardInterrupt:
        complete = sum(one.status != "failed" for one in made.values())
        print(
            f"interrupted: {complete} of {len(entries)} {command}s are complete and kept; "
            "the same command continues from there",
            file=sys.stderr,
        )
        return INTERRUPTED
    if options.check and not options.json:
        print(f"{len(requests)} of {len(entries)} descriptions are right, see {options.out}")
    return code


def _join(
    command: str, entries: Sequence[Entry], words: Sequence[str], spec_of: SpecOf, ranks: int
) -> int:
    """Share the analyses of the first rank of an MPI job, which writes and shows the results."""
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        described = [entry for entry in entries if not _is_result(entry)]
        try:
            made = made_files(described, command, words, spec_of, Path(folder), ranks=ranks)
        except InputError:  # the first rank says so
            return USER_ERROR
    return USER_ERROR if any(one.status == "failed" for one in made) else 0


def _is_result(entry: Entry) -> bool:
    return entry.file.suffix == ".vtkhdf"


class _Bar:
    """Notes in `made` what became of each, and shows how far the work is."""

    def __init__(
        self, unit: str, made: dict[str, Made], total: int, quiet: bool, list_each: bool
    ) -> None:
        self.made, self.total = made, total
        self.bar: Any = None
        if not quiet and sys.stderr.isatty():
            from tqdm import tqdm  # here: without a terminal nothing is drawn

            self.bar = tqdm(total=total, initial=len(made), unit=unit, leave=False)
        self.list_each = list_each and self.bar is None and not quiet
        self.heartbeat = Heartbeat() if self.bar is None and not quiet else None

    def __enter__(self) -> "_Bar":
        return self

    def __exit__(self, *_: object) -> None:
        if self.heartbeat:
            self.heartbeat.close()
        if self.bar is not None:
            self.bar.close()

    def done(self, one: Made) -> None:
        self.made[one.entry.name] = one
        if self.bar is not None:
            self.bar.update()
        if self.list_each:
            line = f"[{len(self.made)}/{self.total}] {one.entry.name}: {one.status}"
            print(line, file=sys.stderr)

    def progress(self, doing: str) -> None:
        if self.heartbeat:
            self.heartbeat.doing = doing
        if self.bar is not None:  # quick ones begin faster than a screen can be read
            due = time.time() - self.bar.last_print_t > self.bar.mininterval
            self.bar.set_postfix_str(doing, refresh=due)
