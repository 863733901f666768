"""What `section`, `shell` and `solid` share: a results file for each description."""

import argparse
import json
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..interrupts import INTERRUPTED
from ..package.common.replaceable import refuse_foreign
from ..package.common.shares import by_mesh, mesh_key
from ..package.common.temporary import temporary_sibling
from .arguments import FOLDERS
from .executors import Executor, Local, executor_of
from .fenicsx_side.launch import Line, kept_preprocessors, make_all, mpi_job, start_of

# Which descriptions a command is given.


@dataclass(frozen=True)
class Entry:
    """One description, or a variant of one; or a results file that is shown again."""

    name: str
    file: Path
    changes: dict[str, Any] = field(default_factory=dict)  # dotted key -> value

    @property
    def where(self) -> str:
        """File and changes, for messages."""
        changes = ", ".join(f"{key} = {value}" for key, value in self.changes.items())
        return f"{self.file} with {changes}" if changes else str(self.file)


def entries_of(files: Iterable[Path]) -> list[Entry]:
    """One entry for each file, named after it; a file that is given twice counts once.

    Raises
    ------
    InputError : two have the same name, and so would have the same results.
    """
    known: dict[str, Path] = {}
    for file in files:
        if (other := known.setdefault(file.stem, file)) != file:
            raise InputError(
                f"{file}: its files would overwrite those of {other}; expected another name, or "
                "one at a time with --out"
            )
    return [Entry(name, file) for name, file in known.items()]


# Have results files made: check descriptions, hand out their specifications, wait.

SpecOf = Callable[[Entry], dict[str, Any]]  # checks a description; raises InputError


@dataclass(frozen=True)
class Made:
    """What became of one description."""

    entry: Entry
    file: Path  # the results file
    status: str  # "built", "unchanged", "failed"
    error: str = ""  # for the user, naming the description
    defect: str = ""  # traceback of an internal error


@dataclass(frozen=True)
class Request:
    """A results file that is to be made."""

    entry: Entry
    spec: Path  # what the FE side reads; the results file appears beside it
    title: str
    mesh: str  # equal for equal meshes


def write_specs(
    entries: Sequence[Entry], folder: Path, spec_of: SpecOf
) -> tuple[list[Request], list[Made]]:
    """Check descriptions and write folder/<name>/<name>.json; those that are wrong have failed."""
    requests, failed = [], []
    for entry in entries:
        spec_file = folder / entry.name / f"{entry.name}.json"
        try:
            spec = spec_of(entry)
        except InputError as error:
            failed.append(Made(entry, spec_file.with_suffix(".vtkhdf"), "failed", str(error)))
            continue
        refuse_foreign(spec_file)
        refuse_foreign(spec_file.with_suffix(".vtkhdf"))  # before the work
        spec_file.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(spec_file) as temporary:
            temporary.write_text(json.dumps(spec, indent=1) + "\n", encoding="utf-8")
        requests.append(Request(entry, spec_file, str(spec.get("title", "")), mesh_key(spec)))
    return requests, failed


def make_files(
    requests: Sequence[Request],
    command: str,
    options: Sequence[str],
    *,
    executor: Callable[[], Executor],
    done: Callable[[Made], None],
    progress: Callable[[str], None],
    ranks: int = 1,
) -> None:
    """Make the results files.

    Parameters
    ----------
    command, options : of the preprocessor
    executor : where; asked for if there is anything to do
    done : called with each file when it is complete
    progress : called with what a worker begins
    ranks : processes of an MPI job that all call this and share each analysis

    Raises
    ------
    InputError : there is no FEniCSx, or the preprocessor does not start.
    """
    if not requests:
        return
    by_spec = {request.spec: request.entry for request in requests}

    def made(spec: Path, line: Line) -> None:
        entry = by_spec[spec]
        error = f"{entry.where}: {line['error']}" if line["error"] else ""
        done(Made(entry, spec.with_suffix(".vtkhdf"), line["status"], error, line["defect"]))

    groups = by_mesh((request.spec, request.mesh) for request in requests)
    start = start_of(command, options, place := executor(), ranks)
    make_all(groups, start, executor=place, done=made, progress=progress)


# Lines that say what a long command is doing, where there is no progress bar.

FIRST_S = 1.5  # a user waits two seconds for a sign of life
LONGER = 2.0  # time from one line to the next over that before


class Heartbeat:
    """Prints the latest step and the time on standard error, less and less often."""

    def __init__(self) -> None:
        self.doing = "starting"
        self._begin = time.monotonic()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def _beat(self) -> None:
        pause = FIRST_S
        while not self._ended.wait(pause):
            seconds = time.monotonic() - self._begin
            print(f"{self.doing}, {seconds:.0f} s", file=sys.stderr, flush=True)
            pause *= LONGER

    def end(self) -> None:
        """Print no more."""
        self._ended.set()
        self._thread.join()


# What is shown of results files: numbers or JSON, failures, names of files.

USER_ERROR = 2


def show_each(
    made: Sequence[Made],
    table_of: Callable[[Made], Any],
    text_of: Callable[[Made], str],
    *,
    as_json: bool,
) -> int:
    """Show one after the other, as text or as one JSON table; returns the exit code."""
    tables: dict[str, Any] = {}
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
        print(json.dumps(next(iter(tables.values())) if len(made) == 1 else tables))
    return code


def tell_failure(one: Made) -> None:
    """Say on standard error why a file has not been made."""
    if one.defect:
        print(one.defect, end="", file=sys.stderr)
        print("this is a defect of the preprocessor, not of the input:", file=sys.stderr)
    for line in one.error.splitlines():
        print(f"error: {line}", file=sys.stderr)


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
        print(f"no figures: {error}; they need pip install plymotion[plot]", file=sys.stderr)
        return []


# From descriptions to results files, with progress on the screen.

Shown = Callable[[list[Made], list[Request]], int]
SHARED = ("section", "shell")  # commands whose analyses the ranks of an MPI job share


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
    rank, ranks = mpi_job() if command in SHARED and not _elsewhere(options) else (0, 1)
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


def _elsewhere(options: argparse.Namespace) -> bool:
    return bool(options.executor or options.scheduler or options.check)


def _join(
    command: str, entries: Sequence[Entry], words: Sequence[str], spec_of: SpecOf, ranks: int
) -> int:
    """Share the analyses of the first rank of an MPI job, which writes and shows the results."""
    code = 0

    def done(made: Made) -> None:
        nonlocal code
        code = USER_ERROR if made.status == "failed" else code

    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        described = [entry for entry in entries if not _is_result(entry)]
        try:
            requests, _ = write_specs(described, Path(folder), spec_of)
            place = Local(1, threads=True)
            make_files(
                requests,
                command,
                words,
                executor=lambda: place,
                done=done,
                progress=lambda _: None,
                ranks=ranks,
            )
        except InputError:  # the first rank says so
            return USER_ERROR
    return code


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
            self.heartbeat.end()
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
