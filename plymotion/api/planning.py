"""`plymotion.plan`: a model chosen once by its accuracy, for many runs with other numbers."""

import hashlib
import json
import random
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..solver.errors import InputError
from ..solver.inputs.case.write import write_case
from ..solver.package.common.files import write_text
from ..solver.package.common.plain_data import plain
from ..solver.results.codes import PLAN_TOO_COARSE
from ..solver.run.execution import execute, read_run
from ..solver.studies.cases import folder_lock
from ..solver.studies.fidelity.answer import answer_text
from ..solver.studies.fidelity.checked_run import (
    answered,
    checked_member,
    member_spec,
    of_model,
    read_planned,
)
from ..solver.workers.launch import keep_preprocessors
from ..solver.workers.packages import build_needed
from .case import ByName, Case, as_case
from .result import chosen, folder_of, named, path_of, signals_of
from .signal import Signal

CHECKED = 0.05  # of the designs, drawn at random
DESIGN = "design"  # folder in that of the case: packages of the last design


class Plan:
    """The model of a run with `[fidelity]`, for runs of the same case with other numbers.

    Attributes
    ----------
    text : the answer of `plymotion plan`
    met : the request is met in the run of the case
    estimate : estimated error of the model by signal, of its largest value; runs take this model
    checks : of the designs that were checked: changes, met, estimate, reason

    Examples
    --------
    >>> import plymotion as pm
    >>> case = pm.load("pendulum.toml")
    >>> case.fidelity = {"accuracy": 1e-3, "signals": ["tip_x"]}
    >>> plan = pm.plan(case, out="build/planned")
    >>> plan.met, plan.estimate["tip_x"] < 1e-3
    (True, True)
    >>> round(plan.run({"gravity.2": -1.62})["tip_x"].final, 1)
    0.4
    >>> plan.check({"gravity.2": -1.62})["met"]
    True
    """

    def __init__(
        self,
        case: Case,
        run: str,
        out: str | Path | None,
        packages: Path | None,
        checked: float,
    ) -> None:
        folder = folder_of(case, out)
        self._case, self._run, self._out, self._folder = case, run, out, folder
        self._packages, self._checked = packages, checked
        file = self._written(case, folder, check=True)
        answer = answered(file)
        self._plan = of_model(answer.plan, answer.spec)  # designs have no package of the check
        if self._plan != answer.plan:
            answer = checked_member(*read_planned(file), self._plan)
        self.text, self.met = answer_text(answer), answer.verdict == "met"
        self.estimate = answer.estimates
        self.checks: list[dict[str, object]] = []

    def run(self, changes: Mapping[str, Any] | None = None) -> ByName[Signal]:
        """Return the signals of a run with other numbers, by the model of the plan.

        Static shapes are those of the loads of this run. A share of the runs, drawn by their
        changes, is checked with the richer model; where the request is not met, a
        `UserWarning` says so.

        Parameters
        ----------
        changes : values by dotted keys, as for `Case.changed`

        Raises
        ------
        InputError
            A wrong key or value; a body that cannot be built.

        >>> import plymotion as pm
        >>> case = pm.load("pendulum.toml")
        >>> case.fidelity = {"accuracy": 1e-3, "signals": ["tip_x"]}
        >>> plan = pm.plan(case, out="build/planned")
        >>> plan.run({"bodies.rod.mass": 3.0})["tip_z"].min < -0.9
        True
        """
        changes = dict(changes or {})
        # The same design is always checked, or never.
        text = json.dumps(sorted((key, plain(value)) for key, value in changes.items()))
        if random.Random(hashlib.sha256(text.encode()).hexdigest()).random() < self._checked:
            self.check(changes)
        spec = read_run(self._written(self._case.changed(changes), self._folder / DESIGN))
        result, summary = execute(member_spec(spec, self._plan), progress=False)
        if summary["status"] != "finished":
            warnings.warn(
                f"the run with {changes} ended at t = {result.t[-1]:.4g} s: {summary['message']}",
                stacklevel=2,
            )
        return signals_of(result)

    def check(self, changes: Mapping[str, Any] | None = None) -> dict[str, object]:
        """Run the model and its check with other numbers: changes, met, estimate, reason.

        Raises InputError as `run` does.

        >>> import plymotion as pm
        >>> case = pm.load("pendulum.toml")
        >>> case.fidelity = {"accuracy": 1e-3, "signals": ["tip_x"]}
        >>> pm.plan(case, out="build/planned").check({"bodies.rod.mass": 3.0})["reason"]
        ''
        """
        changes = dict(changes or {})
        file = self._written(self._case.changed(changes), self._folder / DESIGN, check=True)
        answer = checked_member(*read_planned(file), self._plan)
        entry = {
            "changes": changes,
            "met": answer.verdict == "met",
            "estimate": answer.estimates,
            "reason": answer.reason,
        }
        self.checks.append(entry)
        if not entry["met"]:
            warnings.warn(
                f"[{PLAN_TOO_COARSE.name}] the plan does not reach the accuracy with {changes}: "
                f"{answer.reason}; make a plan there, or ask for less (a larger `accuracy`)",
                stacklevel=2,
            )
        return entry

    def __repr__(self) -> str:
        worst = f"{max(self.estimate.values()):.1e}" if self.estimate else "none"
        met = "met" if self.met else "not met"
        return f"<Plan {self._case.name}/{self._run}: {met}, estimated error of the model {worst}>"

    def _written(self, case: Case, folder: Path, *, check: bool = False) -> Path:
        """Write a design and build what it needs; return its run file."""
        checked = case.check(sweeps=())
        with named(self._out), folder_lock(folder):
            write_case(checked, folder, self._packages)
            file = folder / "runs" / f"{self._run}.json"
            if not check:  # packages of the check cost more than a run
                table = json.loads(file.read_text(encoding="utf-8"))
                table.pop("check_packages", None)
                file = file.with_name(f"{self._run}.model.json")
                write_text(file, json.dumps(table))
            if self._packages is None:
                keep_preprocessors()
                build_needed([file])
        return file


def plan(
    case: Case | str | Path,
    run: str | None = None,
    *,
    out: str | Path | None = None,
    packages: str | Path | None = None,
    checked: float = CHECKED,
) -> Plan:
    """Choose the model of a run with `[fidelity]` once, for many runs; docs/fidelity.md.

    Parameters
    ----------
    case, run, out, packages : as for `plymotion.run`
    checked : share of the later runs that are checked, from 0 to 1

    Raises
    ------
    InputError
        A mistake in the case; a run without `[fidelity]`; a body that cannot be built.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.plan("pendulum.toml")
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: pendulum, run base: expected [fidelity] with accuracy and \
signals
    """
    case = as_case(case)
    if not 0.0 <= checked <= 1.0:
        raise InputError(f"plan(): checked = {checked}: expected from 0 to 1")
    case_used, run, _ = chosen(case, run, out)
    if case_used.runs[run].fidelity is None:
        raise InputError(f"{case.name}, run {run}: expected [fidelity] with accuracy and signals")
    ready = path_of(packages)
    return Plan(case, run, out, ready and ready.resolve(), checked)
