"""The rows of a sweep: what is known, what is computed, and when it is saved."""

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from tqdm import tqdm

from ...errors import InputError
from ...interrupts import held
from ...math.compiled import COMPILED
from ...results import ResultError
from ..cases.finished import state_of
from ..executors.executor import Executor, distribute
from ..executors.local import Local
from .file import believed_rows, result_of, write_sweep
from .member import Row
from .plan import Plan
from .portions import Portions

SAVE_S = 10.0  # least time between two savings on the way


def settled(plan: Plan) -> list[str]:
    """Make the plan of a run with [fidelity], or read it, before members take it.

    Return what is known of it; nothing if the run has no [fidelity]. Raises as `fidelity.settle`.
    """
    if plan.fidelity is None:
        return []
    from .fidelity import settle  # most sweeps need no planner

    return settle(plan)


class Work:
    """Rows of a sweep as they come, and the file that they are saved in.

    Parameters
    ----------
    file : of the rows
    known_in : files that may have some already
    """

    def __init__(self, plan: Plan, file: Path, known_in: Sequence[Path], *, show: bool) -> None:
        self.plan, self.file, self.show = plan, file, show
        self._read = self._states()
        self.keys = plan.keys()
        known = {key: row for path in known_in for key, row in _known(path).items()}
        self.rows = [known.get(key, Row(key)) for key in self.keys]
        self.kept = sum(row.done for row in self.rows)
        self._saved = time.perf_counter()

    def compute(self, executor: Callable[[], Executor]) -> bool:
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
                self._require_unchanged()
                self.rows[number] = row
                if row.defect:
                    bar.write(row.defect, file=sys.stderr, end="")
                    bar.write("this is a defect of the solver, not of the input", file=sys.stderr)
                bar.update()
                self._save_now_and_then()

            try:
                if numbers:
                    _compute(executor(), Portions(self.plan, numbers, self.keys, report))
                return True
            except KeyboardInterrupt:
                return False
            finally:
                self.save()

    def _states(self) -> dict[Path, list[int]]:
        """Return the states of the files that workers read."""
        packages = (self.plan.package_file(k) for k in range(len(self.plan.packages)))
        return {file: state_of(file) for file in (self.plan.file, *packages)}

    def _require_unchanged(self) -> None:
        """Raise InputError for files that are no longer those of the keys of the rows."""
        for file, state in self._states().items():
            if state != self._read[file]:
                raise InputError(
                    f"{file}: was changed while the sweep ran; the same command computes the "
                    "members that are left"
                )

    def save(self) -> None:
        """Write the file; it is whole at any time."""
        with held():
            write_sweep(self.file, result_of(self.plan, self.rows))
        self._saved = time.perf_counter()

    def _save_now_and_then(self) -> None:
        if time.perf_counter() - self._saved > SAVE_S:
            self.save()


def _compute(executor: Executor, portions: Portions) -> None:
    if isinstance(executor, Local) and COMPILED:  # before all workers do
        from ..compile import compile_once

        compile_once()
    distribute(executor, portions)


def _known(file: Path) -> dict[str, Row]:
    """Return the rows of an earlier sweep by key; a file that cannot be read is told and left."""
    if not file.is_file():
        return {}
    try:
        rows, altered = believed_rows(file)
        if altered:
            print(
                f"{file}: {altered} rows were altered after writing; they are computed again",
                file=sys.stderr,
            )
        return rows
    except ResultError as error:
        print(f"{error}; everything is computed again", file=sys.stderr)
        return {}
