"""A run with `[fidelity]`: its plan is made or read, run and checked; the check is delivered."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..package import ModalPackage
from ..results import RunResult
from ..run.execution import package_of, read_run
from ..run.inputs_digest import inputs_sha256, plan_file, plan_sha256, still
from ..run.outcome import RunSpec
from ..run.timing import Stopwatch
from .answer import Answer
from .ladder import tried_models
from .model import vibration_labels
from .plan_file import kept_plan, write_plan
from .procedure import checked, flexible_names, plan_of
from .words import entry, remarks


def read_planned(
    file: Path, spec: RunSpec | None = None, *, allow_doubtful: bool = False
) -> tuple[RunSpec, dict[str, ModalPackage]]:
    """Read a run file with `[fidelity]`, its packages of the model and those of the check.

    Parameters
    ----------
    spec : the run, if it has been read
    allow_doubtful : as in `read_package`

    Raises
    ------
    InputError, PackageError
        See `read_run`.
    """
    spec = spec or read_run(file, allow_doubtful=allow_doubtful)
    table = json.loads(file.read_text(encoding="utf-8"))
    check = dict(spec.packages)  # bodies from files have one package
    for body, of_check in table.get("check_packages", {}).items():
        whose = f"the check of bodies.{body} of case {spec.case}, run {spec.run}"
        path = file.parent.parent / of_check["file"]
        check[body] = package_of(
            path,
            of_check.get("inputs_sha256"),
            whose,
            "run",
            allow_doubtful=allow_doubtful,
        )
    return spec, check


def answered(
    file: Path,
    *,
    again: bool = False,
    check: bool = True,
    spec: RunSpec | None = None,
    digest: str | None = None,
    allow_doubtful: bool = False,
) -> Answer:
    """Return the answer of a run with `[fidelity]`, and write its plan.

    A plan file of the same inputs is used as it is, whether it was edited or not.

    Parameters
    ----------
    again : make the plan again in any case
    check : run model and check
    spec, digest : what `read_run` and `inputs_sha256` return for the file, if known
    allow_doubtful : as in `read_package`
    """
    before = inputs_sha256(file) if digest is None else digest
    spec, packages = read_planned(file, spec, allow_doubtful=allow_doubtful)
    where = plan_file(file)
    digest = still(file, before)
    known = {
        name: {
            "model": vibration_labels(spec.packages[name]),
            "check": vibration_labels(packages[name]),
        }
        for name in flexible_names(spec)
    }
    of_file = plan_sha256(where)
    given = None if again or not digest else kept_plan(where, known, digest)
    answer = plan_of(spec, packages)
    if given is not None:
        answer.plan, answer.plan_sha256 = given, of_file
        return checked(answer, promote=False) if check else answer
    if check:
        answer = checked(answer)
    answer.plan = replace(answer.plan, inputs_sha256=digest)
    write_plan(where, answer.plan, remarks(answer))
    answer.plan_sha256 = plan_sha256(where)
    return answer


def delivered(
    file: Path, spec: RunSpec, digest: str, *, allow_doubtful: bool = False
) -> tuple[RunResult, dict[str, Any]]:
    """Return result and summary of a run file with `[fidelity]`; see `run_file`.

    Parameters
    ----------
    spec, digest : what `read_run` and `inputs_sha256` return for the file
    """
    clock = Stopwatch()
    answer = answered(file, spec=spec, digest=digest, allow_doubtful=allow_doubtful)
    trial = answer.delivered
    assert trial is not None
    clock.lap("integrate")
    result, summary = trial.outcome()
    clock.lap("recover")
    summary["cost"]["seconds"] = clock.seconds
    tried = tried_models(answer)
    summary["fidelity"] = {
        **entry(answer),
        "plan_sha256": answer.plan_sha256,
        "ladder": tried.entry() if tried else None,
    }
    summary["inputs_sha256"] = answer.plan.inputs_sha256
    return result, summary
