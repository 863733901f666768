"""A run with `[fidelity]`: its plan is made or read, run and checked; the check is delivered."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..package import ModalPackage
from ..package.body.selection import vibrations
from ..results import write_result, write_summary
from ..run.execution import package_of, read_run, run_file
from ..run.inputs_digest import inputs_sha256
from ..run.outcome import RunSpec
from ..run.timing import Stopwatch
from .plan import read_plan, write_plan
from .procedure import Answer, checked, flexible_names, plan_of
from .words import entry, remarks


def read_planned(file: Path) -> tuple[RunSpec, dict[str, ModalPackage]]:
    """Read a run file with `[fidelity]`, its packages of the model and those of the check.

    Raises
    ------
    InputError, PackageError
        See `read_run`.
    """
    spec = read_run(file)
    table = json.loads(file.read_text(encoding="utf-8"))
    check = dict(spec.packages)  # bodies from files have one package
    for body, of_check in table.get("check_packages", {}).items():
        whose = f"the check of bodies.{body} of case {spec.case}, run {spec.run}"
        path = file.parent.parent / of_check["file"]
        check[body] = package_of(path, of_check.get("inputs_sha256"), whose, f"make {spec.case}")
    return spec, check


def plan_file(file: Path) -> Path:
    """Return where the plan of a run file is."""
    return file.parent.parent / "plans" / f"{file.stem}.toml"


def labels(package: ModalPackage) -> tuple[str, ...]:
    """Return the labels of the vibrations of a package."""
    return tuple(package.mode_labels[i] for i in vibrations(package).tolist())


def answered(file: Path, *, again: bool = False, check: bool = True) -> Answer:
    """Return the answer of a run with `[fidelity]`, and write its plan.

    A plan file of the same inputs is used as it is, whether it was edited or not.

    Parameters
    ----------
    again : make the plan anew in any case
    check : run model and check
    """
    spec, packages = read_planned(file)
    answer = plan_of(spec, packages)
    digest, where = inputs_sha256(file), plan_file(file)
    known = {
        name: {"model": labels(spec.packages[name]), "check": labels(packages[name])}
        for name in flexible_names(spec)
    }
    given = None
    if where.is_file() and not again:
        given = read_plan(where, known)
        given = given if given.inputs_sha256 == digest else None
    if given is not None:
        answer.plan = given
        return checked(answer, promote=False) if check else answer
    if check:
        answer = checked(answer)
    answer.plan = replace(answer.plan, inputs_sha256=digest)
    write_plan(where, answer.plan, remarks(answer))
    return answer


def run_any(
    file: Path,
    out: Path,
    *,
    progress: bool = True,
    import_s: float = 0.0,
    allow_python: bool = False,
    allow_doubtful: bool = False,
) -> dict[str, Any]:
    """Execute a run file, with `[fidelity]` or without; see `run_file`."""
    if not _asks(file):
        return run_file(
            file,
            out,
            progress=progress,
            import_s=import_s,
            allow_python=allow_python,
            allow_doubtful=allow_doubtful,
        )
    clock, digest = Stopwatch(), inputs_sha256(file)
    answer = answered(file)
    delivered = answer.delivered
    assert delivered is not None
    clock.lap("integrate")
    result, summary = delivered.outcome()
    clock.lap("recover")
    out.mkdir(parents=True, exist_ok=True)
    write_result(out / "result.vtkhdf", result)
    clock.lap("write")
    summary["cost"]["seconds"] = {**clock.seconds, "import": import_s}
    summary["fidelity"] = entry(answer)
    summary["inputs_sha256"] = digest
    write_summary(out / "summary.json", summary)
    return summary


def _asks(file: Path) -> bool:
    try:
        return json.loads(file.read_text(encoding="utf-8"))["mechanism"]["fidelity"] is not None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False  # the ordinary route says what is wrong
