"""The plan of a sweep with [fidelity]: made at its base, checked at members drawn at random."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...package.common.files import kept_table, write_text
from ...results.codes import PLAN_TOO_COARSE
from ...run.inputs import RunSpec
from ..fidelity.answer import Answer, estimate_entry
from ..fidelity.checked_run import checked_member, joined, of_model, shared_plan
from ..fidelity.choice import kept_plan, write_plan
from ..fidelity.plan import known_vibrations
from .sweep_members import Packages, SweepSpec

RECORD = "fidelity.json"


def record_file(sweep: Path) -> Path:
    """Return where the checks of a plan of a sweep file are."""
    return sweep.with_suffix(f".{RECORD}")


def settle(sweep: SweepSpec) -> list[str]:
    """Make the plan of a sweep, or read the one that is there; return what is known of it.

    A plan of the same inputs is kept. One that was edited is checked again, and not changed.

    Raises
    ------
    InputError, PackageError
        The base cannot move; its packages cannot be read; a plan file that is wrong.
    """
    assert sweep.fidelity is not None
    packages, file = Packages(sweep), sweep.model_plan_file
    base = _spec(sweep, packages, sweep.fidelity.base, None)
    check = {**base.packages, **packages.named(sweep.fidelity.base_check)}
    digest = sweep.digest()
    given = kept_plan(file, known_vibrations(base), digest)
    before = record_file(sweep.file)
    record = kept_table(before)
    if given is not None and record.get("plan") == given.table():
        return list(record["lines"])
    members = []
    for drawn in sweep.fidelity.drawn:
        spec = _spec(sweep, packages, sweep.members[drawn.member].packages, drawn.member)
        of_check = {**spec.packages, **packages.named(drawn.check)}
        members.append((drawn.member, (spec, of_check)))
    answer = checked_member(base, check, given) if given else shared_plan(base, check)
    model = answer.plan
    answers = {k: checked_member(*member, model) for k, member in members}
    if given is None and any(one.verdict != "met" for one in answers.values()):
        for k, (spec, of_check) in members:
            if answers[k].verdict != "met":
                better = checked_member(spec, of_check, model, promote=True).plan
                model = joined(model, of_model(better, spec))
        if model != answer.plan:
            answer = checked_member(base, check, model)
            answers = {k: checked_member(*member, model) for k, member in members}
    model = replace(model, inputs_sha256=digest)
    lines = _lines(sweep, answer, answers)
    if given is None:
        write_plan(file, model, [f"Plan of sweep {sweep.name} of case {sweep.case}.", *lines])
    content = {
        "plan": model.table(),
        "base": _entry(answer),
        "members": {str(k): _entry(one) for k, one in answers.items()},
        "lines": lines,
    }
    write_text(record_file(sweep.file), json.dumps(content, indent=1) + "\n")
    return lines


def _spec(
    sweep: SweepSpec, packages: Packages, numbers: Mapping[str, int], member: int | None
) -> RunSpec:
    mechanism = sweep.base if member is None else sweep.mechanism_of(member)
    return RunSpec(sweep.case, sweep.run, mechanism, packages.named(numbers))


def _entry(answer: Answer) -> dict[str, object]:
    return {
        "verdict": answer.verdict,
        "reason": answer.reason,
        "estimate": estimate_entry(answer),
    }


def _lines(sweep: SweepSpec, answer: Answer, answers: Mapping[int, Answer]) -> list[str]:
    """Return the plan and its checks in words; a member where it is too coarse is a warning."""
    names = [parameter.name for parameter in sweep.parameters]
    lines = [f"plan at the base: {_words(answer)}"]
    for k, one in answers.items():
        values = zip(names, sweep.members[k].values, strict=True)
        where = ", ".join(f"{name} = {value:g}" for name, value in values)
        lines.append(f"checked at member {k} ({where}): {_words(one)}")
    coarse = [str(k) for k, one in answers.items() if one.verdict != "met"]
    if coarse or answer.verdict != "met":
        places = ["the base"] if answer.verdict != "met" else []
        places += [f"member {k}" for k in coarse]
        lines.append(
            f"warning [{PLAN_TOO_COARSE.name}] the plan does not reach the accuracy at "
            f"{', '.join(places)}: ask for less (a larger `accuracy`), allow a larger `budget`, "
            "divide the sweep, or edit its `.plan.toml`"
        )
    return lines


def _words(answer: Answer) -> str:
    estimate = "no estimate"
    worst = max(answer.estimates.values(), default=np.inf)
    if np.isfinite(worst):
        estimate = f"estimated error of the model {worst:.1e}"
    reason = f" ({answer.reason})" if answer.reason else ""
    return f"accuracy {answer.spec.fidelity.accuracy:g} {answer.verdict}, {estimate}{reason}"
