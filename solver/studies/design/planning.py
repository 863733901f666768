"""The plan of a run with `[fidelity]`: made once for a study, and made anew at its best design."""

from dataclasses import replace

import numpy as np

from ...errors import InputError, few
from ...inputs.case.bodies.specifications import model_and_check
from ...math.arrays import Array
from ...package import ModalPackage
from ...run.execution import package_of
from ...run.inputs import RunSpec
from .trials import StudySpec, Trials

PLAN = "plan.toml"


def designed_bodies(trials: Trials) -> list[str]:
    """Return the flexible bodies whose specification depends on a parameter."""
    study = trials.study
    points = [study.start]
    for k, parameter in enumerate(study.parameters.values()):
        low, high = parameter.range()
        inside = 1.0 if study.start[k] < 0.5 * (low + high) else -1.0
        points.append(study.start + 0.01 * inside * (high - low) * np.eye(study.start.size)[k])
    own, *others = [model_and_check(b)[0] for b in study.designs(points).own.bodies]
    return [n for n, s in own.items() if any(o[n].inputs_sha256 != s.inputs_sha256 for o in others)]


def with_plan(trials: Trials) -> StudySpec:
    """Return the study with the plan of its run, if that has `[fidelity]`.

    Raises
    ------
    InputError
        All bodies that are designed are rigid, in the case or by the plan: no objective would
        depend on them.
    """
    given, study = trials.given, trials.study
    where = f"{given.file}: design.studies.{study.name}"
    names = designed_bodies(trials)
    rigid = [name for name in names if getattr(study.base.bodies.get(name), "rigid", False)]
    if names and len(rigid) == len(names):
        raise InputError(
            f"{where}.run: {few(rigid)} rigid in run {study.table.run}: nothing of it depends on "
            "the design; expected a run with flexible bodies"
        )
    fidelity = study.base.fidelity
    if fidelity is None or not trials.runs:
        return given
    from ..fidelity.checked_run import shared_plan
    from ..fidelity.choice import kept_plan, write_plan  # most studies need no planner
    from ..fidelity.plan import known_vibrations

    spec, check = _specs(trials, study.start)
    digest = trials.digest()
    plan = kept_plan(given.folder / PLAN, known_vibrations(spec), digest)
    if plan is None:
        plan = replace(shared_plan(spec, check).plan, inputs_sha256=digest)
        write_plan(given.folder / PLAN, plan, [f"Frozen for the study {study.name}."])
    for name in names:
        if name in plan.bodies and plan.bodies[name].rigid:
            raise InputError(
                f"{where}.run: the plan of [fidelity] accuracy = {fidelity.accuracy:g} makes the "
                f"designed body {name} rigid: nothing of the run depends on its design; expected "
                "a smaller accuracy, or a run without [fidelity]"
            )
    return replace(given, plan=plan)


def plan_again(trials: Trials, p: Array) -> dict[str, object]:
    """Return whether the frozen plan reaches its accuracy at a design, and the plan made there."""
    from ..fidelity.checked_run import checked_member, shared_plan

    spec, check = _specs(trials, p)
    frozen, anew = checked_member(spec, check, trials.given.plan), shared_plan(spec, check)
    worst = max(frozen.estimates.values(), default=np.inf)
    return {
        "verdict": frozen.verdict,
        "estimate": worst if np.isfinite(worst) else None,
        "same": anew.plan.table()["bodies"] == trials.given.plan.table()["bodies"],
    }


def _specs(trials: Trials, p: Array) -> tuple[RunSpec, dict[str, ModalPackage]]:
    """Return the run of a design with its packages, and those of its check."""
    own = trials.study.designs([p]).own
    model, check = model_and_check(own.bodies[0])
    files = trials.build([*model.items(), *check.items()])
    spec = trials.spec(trials.study.table.run, own, 0, files)
    packages = {
        name: package_of(files[s.inputs_sha256], s.inputs_sha256, f"the check of {name}", "run")
        for name, s in check.items()
    }
    trials.forget(files)
    return spec, {**spec.packages, **packages}
