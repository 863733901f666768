"""The command `plymotion sweep`."""

import argparse
import os
import sys
import time
from pathlib import Path

from tqdm import tqdm

from ...interrupts import INTERRUPTED, held
from ...math.compiled import COMPILED
from ...package.common.temporary import temporary_sibling
from ...results import ResultError
from ..exit_codes import INCOMPLETE
from .engine import compute_by_workers, compute_here
from .figure import draw_sweep
from .file import SweepResult, believed_rows, result_of, sweep_csv, write_sweep
from .member import FAILED, FINISHED, PENDING, STOPPED, Row
from .plan import Plan, read_plan

SAVE_S = 10.0  # least time between two savings on the way
TOLD = 10  # members that did not finish, on the screen
CSV = "sweep.csv"  # written last: the sign of a sweep that is through


def run_sweep(options: argparse.Namespace) -> int:
    """Compute a sweep; return 0, or 3 if a member failed or stopped, 130 if interrupted."""
    plan = read_plan(options.sweep, allow_doubtful=options.allow_doubtful)
    folder: Path = options.out or options.sweep.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "sweep.h5"
    work = _Work(plan, file, fresh=options.fresh, show=not options.quiet)
    begin = time.perf_counter()
    through = work.compute(options.jobs)
    result = result_of(plan, work.rows)
    if not through:
        print(
            f"{plan.name}: interrupted; {len(plan.members) - result.count(PENDING)} of "
            f"{len(plan.members)} members are in {file}, the same command goes on from there",
            file=sys.stderr,
        )
        return INTERRUPTED
    text = sweep_csv(result)
    if options.figures:
        draw_sweep(folder, result)
    with temporary_sibling(folder / CSV) as temporary:
        temporary.write_text(text, encoding="utf-8")
    if options.csv:
        print(text, end="")
    else:
        _tell(result, work.kept, time.perf_counter() - begin, file)
    return INCOMPLETE if result.count(FAILED, STOPPED) else 0


class _Work:
    """Rows of a sweep as they come, and the file that they are saved in."""

    def __init__(self, plan: Plan, file: Path, *, fresh: bool, show: bool) -> None:
        self.plan, self.file, self.show = plan, file, show
        self.keys = plan.keys()
        known = {} if fresh else _known(file)
        self.rows = [known.get(key, Row(key)) for key in self.keys]
        self.kept = sum(row.done for row in self.rows)
        self._saved = time.perf_counter()

    def compute(self, jobs: int) -> bool:
        """Compute what is pending; False if interrupted. What is known then is in the file."""
        numbers = [k for k, row in enumerate(self.rows) if not row.done]
        with tqdm(
            total=len(self.rows),
            initial=self.kept,
            desc=self.plan.name,
            unit="member",
            disable=None if self.show else True,
            leave=False,
        ) as bar:

            def report(number: int, row: Row) -> None:
                self.rows[number] = row
                if row.defect:
                    bar.write(row.defect, file=sys.stderr, end="")
                    bar.write("this is a defect of the solver, not of the input", file=sys.stderr)
                bar.update()
                self._save_now_and_then()

            try:
                if min(jobs, len(numbers)) > 1:
                    if COMPILED:  # once, before all workers do
                        from ..compile import compile_ahead

                        compile_ahead()
                    return compute_by_workers(self.plan, numbers, self.keys, jobs, report)
                return compute_here(self.plan, numbers, self.keys, report)
            finally:
                self.save()

    def save(self) -> None:
        """Write the file; it is whole at any time."""
        with held():
            write_sweep(self.file, result_of(self.plan, self.rows))
        self._saved = time.perf_counter()

    def _save_now_and_then(self) -> None:
        if time.perf_counter() - self._saved > SAVE_S:
            self.save()


def _known(file: Path) -> dict[str, Row]:
    """Return the rows of an earlier sweep by key; a file that cannot be read is told and left."""
    if not file.is_file():
        return {}
    try:
        rows, altered = believed_rows(file)
        if altered:
            print(
                f"{file}: {altered} rows were altered after writing; they are computed anew",
                file=sys.stderr,
            )
        return rows
    except ResultError as error:
        print(f"{error}; everything is computed anew", file=sys.stderr)
        return {}


def _tell(result: SweepResult, kept: int, seconds: float, file: Path) -> None:
    """Print what became of the members."""
    total = len(result.rows)
    counts = [f"{result.count(s)} {s}" for s in (FINISHED, STOPPED, FAILED) if result.count(s)]
    shown = os.path.relpath(file)
    print(f"{result.name}: {total} members, {', '.join(counts)}; {shown}, {CSV}")
    print(f"  {total - kept} computed in {seconds:.1f} s, {kept} kept from before")
    others = [(k, row) for k, row in enumerate(result.rows) if row.status != FINISHED]
    for k, row in others[:TOLD]:
        values = zip(result.parameter_names, result.values[k], strict=True)
        where = ", ".join(f"{name} = {value:g}" for name, value in values)
        code = f" [{row.code}]" if row.code else ""
        print(f"  {row.status}{code} {where}: {row.message}")
    if len(others) > TOLD:
        print(f"  ... and {len(others) - TOLD} more, see {CSV}")
    doubts: dict[str, int] = {}
    for row in result.rows:
        for code in row.warnings:
            doubts[code] = doubts.get(code, 0) + 1
    for code, count in sorted(doubts.items()):
        print(f"  warning [{code}] in {count} of {total} members")
