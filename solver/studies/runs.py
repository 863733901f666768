"""Runs of run files, in one process or more."""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import InputError, PackageError, few
from ..math.compiled import tell_if_slow
from ..package.common.files import refuse_foreign
from ..results import RunResult, Summary
from ..results.summary import damping_lines, invalid_words
from ..run.execution import run_file
from ..run.inputs import RunSpec, up_to_date
from ..run.timing import timing_text
from ..system.interrupts import (
    INTERRUPTED,
    ending_words,
    handle,
    note,
    of_a_signal,
    passed_to_children,
    stop_requested,
)
from ..system.platform import context, end_with_parent, processes
from .exit_codes import DEFECT, INCOMPLETE, INPUT, report

if TYPE_CHECKING:
    from concurrent.futures import Future

# One run file, with `[fidelity]` or without: what commands and the Python interface call.


def _planned(
    file: Path, spec: RunSpec, digest: str, allow_doubtful: bool
) -> tuple[RunResult, Summary]:
    """Execute a run with `[fidelity]`."""
    from .fidelity.checked_run import delivered  # most runs need no planner

    return delivered(file, spec, digest, allow_doubtful=allow_doubtful)


run_one = partial(run_file, planned=_planned)


# Runs of run files, in one process or more.

DONE = "done"


@dataclass(eq=False, repr=False)
class Outcome:
    """What became of one run file: exit code, lines about it, errors."""

    code: int
    text: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)


class _Task(NamedTuple):
    file: Path
    timing: bool
    run: Callable[..., Summary]


def run_files(
    files: Sequence[Path],
    *,
    out: Path | None = None,
    out_dir: Path | None = None,
    update: bool = False,
    jobs: int = 1,
    timing: bool = False,
    quiet: bool = False,
    allow_python: bool = False,
    allow_doubtful: bool = False,
) -> Iterator[Outcome]:
    """Integrate the runs of run files; yield what became of each.

    Parameters
    ----------
    out : folder for the results of one run
    out_dir : folder for a folder per run; None: above the run files
    update : only runs whose inputs or solver have changed
    jobs : processes
    allow_python : run the Python functions that a case names as controllers
    allow_doubtful : warn of packages that `validate` would refuse, if they can be used
    """
    import_s = time.process_time()
    doubled = {file.stem for file in files if sum(f.stem == file.stem for f in files) > 1}
    if doubled:
        raise InputError(f"run files of the same name: {few(sorted(doubled))}")
    allowed = {"allow_python": allow_python, "allow_doubtful": allow_doubtful}
    tasks = []
    for file in files:
        folder = out or (out_dir or file.parent.parent) / file.stem
        for name in ("result.vtkhdf", "summary.json"):
            refuse_foreign(folder / name)  # before the work
        known = up_to_date(file, folder) if update else None
        if known is not None:
            yield Outcome(_code(known), [f"{file.stem}: up to date"])
            continue
        run = partial(run_one, file, folder, progress=not quiet, import_s=import_s, **allowed)
        tasks.append(_Task(file, timing, run))
        import_s = 0.0
    if tasks:
        tell_if_slow()
    jobs = min(jobs, len(tasks))
    yield from _by_workers(tasks, jobs) if jobs > 1 else _here(tasks)


def _outcome(task: _Task) -> Outcome:
    """Do one run."""
    try:
        summary = task.run()
    except InputError as error:
        lines = str(error).splitlines()
        named = any(str(task.file) in line for line in lines)
        return Outcome(INPUT, errors=lines if named else [f"{task.file}: {x}" for x in lines])
    except PackageError as error:  # names the file of the package
        return Outcome(INPUT, errors=str(error).splitlines())
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return Outcome(INPUT, errors=[f"{where}{error.strerror or error}"])
    except KeyboardInterrupt:
        return Outcome(INTERRUPTED, errors=[f"{task.file}: {ending_words()}"])
    except Exception as error:
        if of_a_signal(error):
            return Outcome(INTERRUPTED, errors=[f"{task.file}: {ending_words()}"])
        from ..inputs.case.messages import ERRORS, out_of_range

        if isinstance(error, ERRORS):
            mechanism = json.loads(task.file.read_text(encoding="utf-8"))["mechanism"]
            if message := out_of_range(str(task.file), mechanism):
                return Outcome(INPUT, errors=[message])
        return Outcome(DEFECT, errors=[f"{task.file}: {report(error)}"])
    return Outcome(_code(summary), _lines(summary, task.timing))


def _code(summary: Summary) -> int:
    if summary["status"] == "interrupted":
        return INTERRUPTED
    refused = summary.get("fidelity", {}).get("verdict") == "not met"
    return INCOMPLETE if refused or _ending(summary) != DONE else 0


def _ending(summary: Summary) -> str:
    """Return how a run ended, in a word or two."""
    if not summary["completed"]:
        return str(summary["status"])
    return invalid_words(summary) or DONE


def _lines(summary: Summary, timing: bool) -> list[str]:
    cost = summary["cost"]
    ending = _ending(summary)
    outcome = ending if ending == DONE or not summary["completed"] else f"{ending}, ended"
    text = [
        f"{summary['run']}: {outcome} at t = {summary['t_end']:.4g} s, "
        f"{cost['steps']} steps, {cost['solve_s']:.2f} s"
    ]
    if "fidelity" in summary:
        from .fidelity.answer import fidelity_line

        text.append(f"  {fidelity_line(summary['fidelity'])}")
    if "error_bars" in summary:
        text.append(f"  {error_bars_line(summary)}")
    text += [f"  {line}" for line in damping_lines(summary["damping"])]
    text += [f"  {w['level']} [{w['code']}] {w['message']}" for w in summary["warnings"]]
    return [*text, f"  {timing_text(cost['seconds'])}"] if timing else text


def error_bars_line(summary: Summary) -> str:
    """Return the error bars of a run as a line."""
    bars_entry = summary["error_bars"]
    bars = [
        f"{name} {signal['error_bar']:.2g} {signal['unit']}"
        for name, signal in summary["signals"].items()
        if signal["error_bar"] is not None
    ]
    without = (
        f" (without {', '.join(bars_entry['not_contained'])})"
        if bars_entry["not_contained"]
        else ""
    )
    return f"error bars: {few([bars_entry['reason']] if bars_entry['reason'] else bars)}{without}"


def _here(tasks: list[_Task]) -> Iterator[Outcome]:
    for task in tasks:
        outcome = _outcome(task)
        yield outcome
        if stop_requested() and task is not tasks[-1]:
            yield Outcome(INTERRUPTED)
            return


def _by_workers(tasks: list[_Task], jobs: int) -> Iterator[Outcome]:
    """Do runs in processes; after Ctrl-C those under way end and the others do not begin."""
    import multiprocessing  # these not for a run in this process
    from concurrent.futures import FIRST_COMPLETED, wait
    from concurrent.futures.process import BrokenProcessPool

    stop = context().Event()
    pool = processes(jobs, _begin, stop)

    def children() -> list[int]:
        return [child.pid for child in multiprocessing.active_children() if child.pid is not None]

    with passed_to_children(stop, children), pool:
        quiet = {"progress": False, "import_s": 0.0}
        tasks = [task._replace(run=partial(task.run, **quiet)) for task in tasks]
        waiting: set[Future[Outcome]] = {pool.submit(_in_worker, task) for task in tasks}
        while waiting:
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                try:
                    outcome = future.result()
                except BrokenProcessPool:
                    raise InputError(
                        "a process that integrated a run died (out of memory?): use --jobs 1"
                    ) from None
                yield outcome


_stop: Any = None
_busy = False


def _begin(stop: Any) -> None:
    """Prepare a worker: the first signal ends its run, later ones do not disturb the writing."""
    global _stop
    _stop = stop
    end_with_parent()

    def interrupted(number: int, *_: Any) -> None:
        first = not stop_requested()
        note(number)
        if _busy and first:
            raise KeyboardInterrupt

    handle(interrupted)


def _in_worker(task: _Task) -> Outcome:
    global _busy
    _busy = True
    try:
        # A signal to the group may come before the parent sets the event.
        begins = not (_stop.is_set() or stop_requested())
        return _outcome(task) if begins else Outcome(INTERRUPTED)
    except KeyboardInterrupt:
        return Outcome(INTERRUPTED)
    finally:
        _busy = False
