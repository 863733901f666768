"""`plymotion.optimise`: the best design of a study, as `plymotion optimise` finds it."""

import json
from collections.abc import Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from ..solver.errors import InputError, few, nearest
from ..solver.math.arrays import Array
from ..solver.package.common.plain_data import plain
from ..solver.studies.cases import folder_lock
from ..solver.studies.design.design_text import outcome_lines
from ..solver.studies.design.study import RESULT
from ..solver.studies.design.study import optimise as computed
from ..solver.studies.design.trials import StudySpec
from ..solver.studies.exit_codes import shown
from ..solver.workers.executors import Here, Local
from .case import ByName, Case, as_case
from .result import folder_of, named
from .signal import pyplot, table


class Optimum:
    """The results of a study.

    Attributes
    ----------
    folder : path of the folder with design.json
    data : content of design.json (docs/design.md)

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.optimise("pendulum.toml", "light")
    <Optimum pendulum/light: m = 1.5>
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        file = self.folder / RESULT
        if not file.is_file():
            raise InputError(f"{file}: no such file; expected one that `plymotion optimise` wrote")
        self.data: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))

    @cached_property
    def parameters(self) -> ByName[Any]:
        """Values of the parameters at the best design, by name: numbers, or names of a choice.

        >>> import plymotion as pm
        >>> round(pm.optimise("pendulum.toml").parameters["m"], 6)
        1.5
        """
        return ByName("parameters", self.data["optimum"]["values"])

    @property
    def measures(self) -> dict[str, tuple[float, float]]:
        """Objective and limits by their words: values at the start and at the best design.

        >>> import plymotion as pm
        >>> start, best = pm.optimise("pendulum.toml").measures["mass mechanism"]
        >>> start, round(best, 6)
        (2.0, 1.5)
        """
        names = [measure["words"] for measure in self.data["measures"]]
        pairs = zip(self.data["start"]["shown"], self.data["optimum"]["shown"], strict=True)
        return dict(zip(names, pairs, strict=True))

    @property
    def history(self) -> list[Array]:
        """The objective at the iterations of each start.

        >>> import plymotion as pm
        >>> float(pm.optimise("pendulum.toml").history[0][0])
        2.0
        """
        return [
            np.array([point["shown"][0] for point in start["history"]])
            for start in self.data["starts"]
        ]

    @property
    def front(self) -> list[dict[str, Any]]:
        """Designs of a study with `front` of which none is better in both numbers.

        Values of the parameters `p`, and of the objective, limits and second number, `shown`.

        >>> import plymotion as pm
        >>> pm.optimise("pendulum.toml").front
        []
        """
        points: list[dict[str, Any]] = self.data["front"]
        return points

    def changed(self, case: Case) -> Case:
        """Return a case with the best design.

        >>> import plymotion as pm
        >>> case = pm.optimise("pendulum.toml").changed(pm.load("pendulum.toml"))
        >>> round(case.bodies["rod"]["mass"], 6)
        1.5
        """
        return case.changed(self.data["optimum"]["keys"])

    def plot(self, axes: Any = None, **style: Any) -> Any:
        """Draw the objective over the iterations of all starts with matplotlib; return the axes.

        >>> import plymotion as pm
        >>> pm.optimise("pendulum.toml").plot().get_ylabel()
        'mass mechanism [kg]'
        """
        axes = pyplot().gca() if axes is None else axes
        for k, values in enumerate(self.history):
            axes.plot(values, **{"marker": "o", "label": f"start {k}", **style})
        measure = self.data["measures"][0]
        unit = f" [{measure['unit']}]" if measure["unit"] else ""
        axes.set(xlabel="iteration", ylabel=measure["words"] + unit)
        return axes

    def __repr__(self) -> str:
        shown = {n: v if isinstance(v, str) else f"{v:.6g}" for n, v in self.parameters.items()}
        values = ", ".join(f"{n} = {v}" for n, v in shown.items())
        return f"<Optimum {self.data['case']}/{self.data['study']}: {values}>"

    def _repr_html_(self) -> str:
        rows: list[Sequence[Any]] = [[name, *pair] for name, pair in self.measures.items()]
        return table(["", "start", "best"], rows, repr(self).strip("<>"))

    def __str__(self) -> str:
        return "\n".join(outcome_lines(self.data, self.folder))


def optimise(
    case: Case | str | Path,
    study: str | None = None,
    *,
    out: str | Path | None = None,
    coarse: bool = False,
    fresh: bool = False,
    jobs: int = 1,
    progress: bool = False,
) -> Optimum:
    """Search for the best design of a study, or go on with it; docs/design.md.

    Parameters
    ----------
    case : a case, or its file
    study : name of a study of the case; absent: the only one
    out, coarse : as for `run`
    fresh : compute all designs again
    jobs : processes, each with starts of its own
    progress : show progress on standard error

    Raises
    ------
    InputError
        A mistake in the case or the study; a first design that is invalid.
    KeyboardInterrupt
        Ctrl-C; designs that were computed are kept.

    Examples
    --------
    >>> import plymotion as pm
    >>> pm.optimise("pendulum.toml", "heavy")
    Traceback (most recent call last):
    plymotion.solver.errors.InputError: pendulum: expected the name of a study; known: light
    """
    given = study_spec(case, study, out, coarse=coarse)
    with shown(steps=progress), named(out), folder_lock(given.folder.parent.parent):
        computed(given, Here if jobs == 1 else partial(Local, jobs), fresh=fresh, show=progress)
        return Optimum(given.folder)


def study_spec(
    case: Case | str | Path, study: str | None, out: str | Path | None, *, coarse: bool
) -> StudySpec:
    """Return a study of a case. Raises InputError: the case has no such study, or several.

    Parameters
    ----------
    case : case, or its file
    study : name of the study; None: the only one
    out : folder of the results; None: build/CASE
    coarse : with the changes of [coarse]
    """
    case = as_case(case)
    design = case.table.get("design", {})
    studies = list(design.get("studies", {}))
    study = study or (studies[0] if len(studies) == 1 else "")
    if study not in studies:
        known = f": {few(studies)}" if studies else "; the case has none"
        hint = nearest(study, studies) if study and studies else known
        raise InputError(f"{case.name}: expected the name of a study{hint}")
    folder = folder_of(case, out, coarse=coarse)
    return StudySpec(plain(case.table), case._path, coarse, study, folder / "studies" / study)
