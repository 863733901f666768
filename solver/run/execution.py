"""One run: packages, model, consistent start, integration, results."""

import json
import logging
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..checks.course import stall_finding
from ..checks.finished_run import FinishedRun
from ..checks.statics import unjudged_hints
from ..errors import PackageError, not_by_check
from ..inputs.case.record import sealed
from ..integrators.generic.drive import Steps, StopRequest, Watch
from ..package import ModalPackage, read_package
from ..results import RunResult, Summary, write_result, write_summary
from ..results.codes import Finding
from ..results.live import Copies
from ..system.interrupts import completing, stop_requested
from .inputs import RunSpec, inputs_sha256, still
from .outcome import collect, disk_note, nearest_folder
from .preparation import Prepared, histories_of, integrated, prepare
from .timing import FIRST_LINE_S, StageProgress, Stopwatch

LOGGER = logging.getLogger(__name__)

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism

# To complete the files of a run after a signal: CPU time, of the second within which a program
# answers at once (Nielsen, Usability Engineering, 1993, 5.5), less the end of a large process; or
# part of that of its integration. Wall time would lose what a busy machine has computed.
PATIENCE_S, PATIENCE = 0.3, 0.05


def read_run(file: Path, *, allow_doubtful: bool = False) -> RunSpec:
    """Read build/<case>/runs/<run>.json and the packages that it names.

    `allow_doubtful` as in `read_package`.

    Raises
    ------
    InputError, PackageError
        Not a run file; a package that cannot be read or was built from other inputs.
    """
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        if "members" in table:
            raise ValueError("a sweep, which `plymotion sweep` computes")
        case, run = str(table["case"]), str(table["run"])
        mechanism = _mechanism(table, str(file))
        entries = _entries(table, mechanism)
        others = {
            name: (_mechanism(each, str(file)), each)
            for name, each in table.get("other_runs", {}).items()
        }
        of_others = {name: _entries(each, other) for name, (other, each) in others.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise not_by_check(file, "run file", error) from error

    # Segments of a body and other runs share files: each is read once.
    read: dict[tuple[str, str | None], ModalPackage] = {}

    def packages(run: str, entries: list[tuple[str, str, str | None]]) -> dict[str, ModalPackage]:
        for body, name, digest in entries:
            if (name, digest) not in read:
                whose = f"bodies.{body} of case {case}, run {run}"
                path = file.parent.parent / name
                read[name, digest] = package_of(
                    path, digest, whose, "run", allow_doubtful=allow_doubtful
                )
        return {body: read[name, digest] for body, name, digest in entries}

    known = {
        name: RunSpec(case, name, other, packages(name, of_others[name]))
        for name, (other, _) in others.items()
    }
    units = str(table.get("units", "m"))
    return RunSpec(case, run, mechanism, packages(run, entries), known, units)


def _entries(table: Any, mechanism: "Mechanism") -> list[tuple[str, str, str | None]]:
    """Return bodies with files and digests of their packages. Raises ValueError."""
    entries = [(body, *_entry(entry)) for body, entry in table["packages"].items()]
    unknown = [body for body, *_ in entries if body not in mechanism.bodies]
    if unknown:
        raise ValueError(f"packages.{unknown[0]}: there is no such body")
    return entries


def _entry(entry: Any) -> tuple[str, str | None]:
    """Return file and digest of a package. Raises ValueError for other content."""
    name, digest = entry["file"], entry.get("inputs_sha256")
    if not isinstance(name, str) or "\0" in name or not isinstance(digest, str | None):
        raise ValueError(f"packages: expected file and inputs_sha256, found {entry!r}")
    return name, digest


def _mechanism(table: Any, where: str) -> "Mechanism":
    """Return the mechanism of a run file; one that was edited is checked."""
    mechanism = sealed(table["mechanism"], table.get("checked"))
    if mechanism is None:
        from ..inputs.case.tables.schema import resolved  # takes 0.2 s

        mechanism = resolved(table["mechanism"], where)
    return mechanism


def package_of(
    path: Path, expected: str | None, whose: str, kind: str, *, allow_doubtful: bool = False
) -> ModalPackage:
    """Read the package that a run file names.

    Parameters
    ----------
    expected : hash of the inputs that it must have been built from; None: any
    whose, kind : body, and kind of the file that names it ("run", "sweep"), for messages
    allow_doubtful : as in `read_package`

    Raises
    ------
    PackageError
        It cannot be read, or was built from other inputs.
    """
    path = path.resolve()
    shown = path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
    remedy = f"`plymotion packages` with the {kind} file builds it"
    if expected is not None and not path.exists():
        raise PackageError(f"{shown}: no such file; {remedy}")
    package = read_package(shown, allow_doubtful=allow_doubtful)
    inputs = package.provenance.get("inputs_sha256")
    if expected is not None and inputs != expected:
        raise PackageError(
            f"{shown}: built from other inputs than {whose} "
            f"(inputs {str(inputs)[:12]}, expected {expected[:12]}); {remedy}"
        )
    return package


class Progress:
    """Show simulated time and pass the steps on to the monitors.

    On a terminal by a bar; elsewhere by lines, the first after 2 s, then at doubled intervals.
    """

    def __init__(self, watch: Watch, t_end: float, label: str, show: bool) -> None:
        self.watch, self.note = watch, watch.note
        self.t_end, self.label, self.steps, self._show = t_end, label, 0, show
        self.copies: Copies | None = None  # that write the results so far
        self.findings: list[Finding] = []  # of monitors, shown as they grow
        self._shown = 0
        self.begin, self.next = time.perf_counter(), FIRST_LINE_S if show else np.inf
        self.seconds = 0.0  # CPU time of the monitors
        self.bar: Any = None
        if show and sys.stderr.isatty():
            from tqdm import tqdm  # here: without a terminal nothing is drawn

            self.bar = tqdm(
                total=t_end,
                desc=label,
                unit="s",
                bar_format="{desc}: {percentage:3.0f}% |{bar}| {n:.3f}/{total:.3f} s [{elapsed}]",
                leave=False,
                mininterval=0.2,
            )

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Show steps, and let the monitors look at them."""
        self.steps += len(steps)
        if self.bar is not None:
            self.bar.update(steps.t[-1] - self.bar.n)
        elif time.perf_counter() - self.begin > self.next:
            self.next *= 2.0
            self.tell(
                f"t = {steps.t[-1]:.6g} of {self.t_end:g} s, {self.steps} steps, "
                f"{time.perf_counter() - self.begin:.0f} s"
            )
        begin = time.process_time()
        try:
            return self.watch(steps) or self._copied(float(steps.t[-1]))
        finally:
            self.seconds += time.process_time() - begin
            for finding in self.findings[self._shown :]:
                self.tell(finding.text)
            self._shown = len(self.findings)

    def _copied(self, t: float) -> StopRequest | None:
        """End the run here if this process is a copy, which shows nothing."""
        code = "" if self.copies is None else self.copies.code()
        if not code:
            return None
        self._show, self.bar = False, None
        text = f"the run is under way, at t = {t:.6g} of {self.t_end:g} s; this is its part so far"
        return StopRequest(t, text, code)

    def tell(self, text: str) -> None:
        """Show a line at once."""
        if self._show:
            LOGGER.info("%s: %s", self.label, text)

    def close(self) -> None:
        """Remove the bar."""
        if self.bar is not None:
            self.bar.close()


def execute(
    spec: RunSpec,
    *,
    progress: bool = True,
    folder: Path | None = None,
    allow_python: bool = False,
) -> tuple[RunResult, Summary]:
    """Integrate one run; return the result and the summary.

    Parameters
    ----------
    folder : for files without a name, of results that are too many for memory; None: that of
        temporary files. The arrays of the result are then LongRows (math/rows.py)

    Raises
    ------
    InputError
        A mechanism that cannot be assembled, contradictory constraints, an integrator that
        does not go with the treatment of constraints.
    """
    clock = Stopwatch()
    solved = _solved(spec, clock, progress, folder, allow_python=allow_python)
    return _collected(spec, *solved, clock, folder, progress)


def _solved(
    spec: RunSpec,
    clock: Stopwatch,
    progress: bool,
    folder: Path | None,
    *,
    allow_python: bool = False,
    copies: Copies | None = None,
) -> tuple[Prepared, FinishedRun, float]:
    """Return the mechanism, its motion, and the wall time of both [s]."""
    begin = time.perf_counter()
    prepared = prepare(
        spec.mechanism,
        spec.packages,
        allow_python=allow_python,
        histories=histories_of(
            spec.mechanism.signals,
            spec.other_runs,
            spec.mechanism.solver,
            allow_python=allow_python,
        ),
        units=spec.units,
    )
    clock.lap("build")
    follow = Progress(prepared.watch, spec.mechanism.solver.t_end, spec.run, progress)
    follow.copies = copies
    if prepared.buckling is not None:
        follow.findings = prepared.buckling.findings
    try:
        finished = integrated(
            prepared,
            follow,
            on_stall=lambda stall: follow.tell(stall_finding(prepared.built, stall).text),
            on_note=lambda finding: follow.tell(finding.text),
            folder=folder,
        )
    finally:
        follow.close()
    seconds = time.perf_counter() - begin
    clock.lap("integrate")
    clock.move(follow.seconds, "integrate", "monitors")
    return prepared, finished, seconds


def _collected(
    spec: RunSpec,
    prepared: Prepared,
    finished: FinishedRun,
    solve_s: float,
    clock: Stopwatch,
    folder: Path | None,
    progress: bool,
    patience_s: float = float("inf"),
) -> tuple[RunResult, Summary]:
    stage = StageProgress(spec.run, "signals and reactions", show=progress, patience_s=patience_s)
    result, summary = collect(spec, prepared.measured, finished, solve_s, folder, stage)
    clock.lap("recover")
    summary["cost"]["seconds"] = clock.seconds
    for text in unjudged_hints(finished) if progress else ():
        LOGGER.info("%s: %s", spec.run, text)
    return result, summary


# Result and summary of a run file with `[fidelity]`, from file, run and digest of its inputs, and
# whether doubtful packages are used.
Planned = Callable[[Path, RunSpec, str, bool], tuple[RunResult, Summary]]


def run_file(
    file: Path,
    out: Path,
    *,
    progress: bool = True,
    import_s: float = 0.0,
    allow_python: bool = False,
    allow_doubtful: bool = False,
    planned: Planned | None = None,
) -> Summary:
    """Execute a run file and write result.vtkhdf and summary.json into `out`.

    Parameters
    ----------
    import_s : CPU time that the program had taken before, for the summary [s]
    allow_python : functions of the user may run
    allow_doubtful : as in `read_package`
    planned : executes a run with `[fidelity]`; None: its model is that of the case
    """
    clock, digest = Stopwatch(), inputs_sha256(file)
    spec = read_run(file, allow_doubtful=allow_doubtful)
    digest = still(file, digest)
    clock.lap("load")
    disk = nearest_folder(out)
    if note := disk_note(spec, disk):
        LOGGER.warning("%s: %s", spec.run, note)
    if planned is not None and spec.mechanism.fidelity is not None:
        result = planned(file, spec, digest, allow_doubtful)
        return _written(out, spec, *result, digest, clock, import_s, progress)
    solving, copies = Stopwatch(), Copies(out)
    with copies.ending():
        solved = _solved(spec, solving, progress, disk, allow_python=allow_python, copies=copies)
        patience_s = max(PATIENCE_S, PATIENCE * sum(solving.seconds.values()))
        digest, progress = ("", False) if copies.is_copy else (digest, progress)
        with completing(patience_s):  # what is computed is kept
            collected = _collected(spec, *solved, solving, disk, progress, patience_s)
            if spec.mechanism.solver.error_bars and collected[1]["completed"]:
                from .error_bars import with_error_bars

                again = partial(execute, progress=progress, folder=disk, allow_python=allow_python)
                with_error_bars(collected[1], spec, collected[0], again)
                digest = "" if stop_requested() else digest  # the bars are not complete
            target = copies.out
            return _written(target, spec, *collected, digest, clock, import_s, progress, patience_s)


def _written(
    out: Path,
    spec: RunSpec,
    result: RunResult,
    summary: Summary,
    digest: str,
    clock: Stopwatch,
    import_s: float,
    progress: bool,
    patience_s: float = float("inf"),
) -> Summary:
    """Write result and summary of a run; return the summary."""
    clock.skip()
    out.mkdir(parents=True, exist_ok=True)
    every = spec.mechanism.solver.node_positions == "all"
    stage = StageProgress(spec.run, "writing", show=progress, patience_s=patience_s)
    write_result(out / "result.vtkhdf", result, all_positions=every, progress=stage)
    clock.lap("write")
    seconds = summary["cost"]["seconds"]
    seconds["import"] = import_s
    seconds["load"] += clock.seconds["load"]
    seconds["write"] = clock.seconds["write"]
    summary.setdefault("inputs_sha256", digest)  # a run with a plan reads more, later
    # Last: the sign of a finished run.
    write_summary(out / "summary.json", summary)
    return summary
