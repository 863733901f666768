"""A study from its first design to the verified best one, and the file that it leaves."""

import json
import logging
import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from tqdm import tqdm

from ...errors import InputError, few
from ...inputs.case.bodies.specifications import model_and_check
from ...math.arrays import Array
from ...math.compiled import tell_if_slow
from ...package import ModalPackage
from ...package.common.files import refuse_foreign, write_text
from ...package.common.object_file import unpacked
from ...report.design.page import PAGE, write_page
from ...run.inputs import RunSpec
from ...workers.executors import Executor, Task, distribute
from .design_text import variant_text
from .drivers.table import driver_of
from .problem import undominated
from .rules import layups, space_of
from .starts import Start, compute_start, first_points, forget
from .study_state import FILE, Memory
from .trials import BODIES, StudySpec, Trials

# The plan of a run with `[fidelity]`: made once for a study, and made anew at its best design.

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
    packages = {name: unpacked(files[s.inputs_sha256].read_bytes()) for name, s in check.items()}
    trials.forget(files)
    return spec, {**spec.packages, **packages}


LOGGER = logging.getLogger(__name__)
RESULT, VARIANT = "design.json", "optimum.toml"
FORMAT = "plymotion design"


class _Starts:
    """The source of an executor (workers/executors.py): the starts of a study."""

    def __init__(
        self, given: StudySpec, key: str, count: int, took: Callable[[Start], None]
    ) -> None:
        self._given, self._key, self._took = given, key, took
        self._left = list(range(count))[::-1]

    def next(self, lane: int, width: int) -> Task | None:
        """Return the next start."""
        if not self._left:
            return None
        number = self._left.pop()
        return Task(compute_start, (self._given, self._key, number), number)

    def took(self, task: Task, result: Start) -> None:
        """Take a start that has ended."""
        self._took(result)

    def lost(self, task: Task) -> None:
        """Take a start whose worker died; what it had computed is known."""
        self._took(Start(task.content, message="its worker process died (out of memory?)"))


def ready(given: StudySpec, *, fresh: bool = False) -> tuple[StudySpec, Trials, Memory]:
    """Return a study with its plan and the kind of derivatives that it asks for, or can have.

    Raises
    ------
    InputError
        A study that cannot be computed.
    """
    trials = Trials(given)
    table = trials.study.table
    where = f"{given.file}: design.studies.{trials.study.name}"
    driver_of(table.driver, where)
    space_of(trials.study)
    shutil.rmtree(given.folder / BODIES, ignore_errors=True)  # of a command that was killed
    for name in (RESULT, VARIANT, PAGE):
        refuse_foreign(given.folder / name)
    why = "" if table.gradient == "differences" else trials.why_not_exact()
    if why and table.gradient == "exact":
        raise InputError(f'{where}.gradient = "exact": {why}; expected "differences"')
    given = replace(with_plan(trials), exact=table.gradient != "differences" and not why)
    trials = Trials(given)
    return given, trials, Memory(given.folder / FILE, trials.digest(), fresh=fresh)


def optimise(
    given: StudySpec, executor: Callable[[], Executor], *, fresh: bool = False, show: bool = False
) -> dict[str, Any]:
    """Compute a study, or what is missing of it; write and return the content of design.json.

    Parameters
    ----------
    executor : makes what distributes the starts over processes
    fresh : compute again what is known of designs
    show : a progress bar, even where the output is no terminal

    Raises
    ------
    InputError
        A study that cannot be computed, or no start that gave a valid design.
    KeyboardInterrupt
        Ctrl-C or TERM; the same call continues.
    """
    given, trials, memory = ready(given, fresh=fresh)
    study, key = trials.study, memory.key
    where = f"{given.file}: design.studies.{study.name}"
    space = space_of(study)
    forget()
    tell_if_slow()
    done: list[Start] = []
    count = len(first_points(study, space))
    with tqdm(total=count, desc=study.name, unit="start", disable=None if show else True) as bar:

        def took(start: Start) -> None:
            done.append(start)
            bar.set_postfix_str(f"{sum(each.computed for each in done)} designs", refresh=False)
            bar.update()

        distribute(executor(), _Starts(given, key, count, took))
    done.sort(key=lambda start: start.number)
    memory = Memory(given.folder / FILE, key)
    best = _best(done)
    if best is None or best.best is None:
        reasons = list(dict.fromkeys(start.message for start in done))
        raise InputError("\n".join(f"{where}: {reason}" for reason in reasons))
    result = _content(trials, key, done, best, memory)
    if study.table.verify:
        p = np.array(best.best.p)
        result["verified"] = _verified(trials, p, best.best.shown)
        if given.plan is not None:
            result["plan"] = plan_again(trials, p)
    shutil.rmtree(given.folder / BODIES, ignore_errors=True)
    write_text(given.folder / VARIANT, variant_text(result))
    write_page(given.folder, result)
    write_text(given.folder / RESULT, json.dumps(result, indent=1) + "\n")
    return result


def _best(starts: Sequence[Start]) -> Start | None:
    """Return the start with the best design; merits of different starts have their own scale."""
    best: Start | None = None
    for start in starts:
        if start.best is not None and (best is None or start.best.better_than(best.best)):
            best = start
    return best


def _verified(trials: Trials, p: Array, shown: list[float]) -> dict[str, object]:
    """Return what a richer model says of the best design, and the relative differences."""
    verified = trials.richer().values(p)
    return {
        "why": verified.why,
        "shown": verified.shown,
        "difference": [
            (b - a) / (abs(b) or 1.0)
            for a, b in zip(shown, verified.shown, strict=bool(verified.shown))
        ],
    }


def _sensitivities(memory: Memory, p: list[float]) -> list[list[float]]:
    """Return derivatives of the governing value of each measure by the parameters, if known."""
    values, slopes = (memory.get(kind, np.array(p)) for kind in ("values", "slopes"))
    if slopes is None:
        return []
    return [s[int(np.abs(v).argmax())] for v, s in zip(values["values"], slopes, strict=True)]


def _content(
    trials: Trials, key: str, starts: Sequence[Start], best: Start, memory: Memory
) -> dict[str, object]:
    study, table = trials.study, trials.study.table
    assert best.best is not None
    names = list(study.parameters)
    units = memory.get("values", np.array(best.best.p))["units"]
    first = starts[0].history[0] if starts[0].history else None
    p0, p = study.start, np.array(best.best.p)
    return {
        "format": FORMAT,
        "case": trials.case,
        "case_title": trials.given.table["title"],
        "study": study.name,
        "title": table.title or study.name,
        "run": table.run,
        "inputs_sha256": key,
        "driver": table.driver,
        "sense": "minimise" if table.minimise is not None else "maximise",
        "measures": [
            {
                "words": q.words(),
                "least": getattr(q, "least", None),
                "most": getattr(q, "most", None),
                "unit": unit,
            }
            for q, unit in zip(table.quantities(), units, strict=True)
        ],
        "parameters": {
            name: {
                "kind": q.kind,
                "unit": study.unit(name),
                "range": q.range(),
                "names": q.names,
                "targets": [t.key for t in study.targets[name]],
            }
            for name, q in study.parameters.items()
        },
        "gradient": trials.words_of_gradient(),
        "start": {"p": p0.tolist(), "shown": first.shown if first else []},
        "optimum": {
            **asdict(best.best),
            "values": {n: study.parameters[n].shown(x) for n, x in zip(names, p, strict=True)},
            "keys": study.keys(p),
            "start": best.number,
        },
        "layups": [
            {"name": a.name, "before": _layup(b), "after": _layup(a)}
            for b, a in zip(layups(study, p0).values(), layups(study, p).values(), strict=False)
        ],
        "sensitivities": {
            "start": _sensitivities(memory, first.p) if first else [],
            "optimum": _sensitivities(memory, (best.continuous or best.best).p),
        },
        "front": [asdict(p) for p in undominated(p for start in starts for p in start.front)],
        "starts": [asdict(start) for start in starts],
    }


def _layup(layup: Any) -> dict[str, object]:
    return {
        "angles_deg": layup.angles.tolist(),
        "thicknesses": layup.thicknesses.tolist(),
        "materials": list(layup.materials),
    }
