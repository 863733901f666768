"""Runs of a plan: its signals, its cost, its result; and the comparison of two runs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ....checks.finished import FinishedRun
from ....errors import InputError
from ....math.arrays import Array
from ....run.integration import complete
from ....run.outcome import RunSpec, collect
from ....run.preparation import Prepared, prepare
from ....run.timing import work_s
from ....signals import Recording
from ..base.comparison import difference, relatives, scales
from ..base.model import Rich, planned
from ..base.plan import Plan


@dataclass(frozen=True)
class Trial:
    """A run of a plan.

    Attributes
    ----------
    signals : (o, k)
    sizes : (o,) of signals that are rounding or noise: what they are compared with; of others 0
    complete : it reached the end
    cpu : seconds, building and integration
    """

    plan: Plan
    spec: RunSpec
    prepared: Prepared
    finished: FinishedRun
    signals: Array
    sizes: Array
    complete: bool
    cpu: float

    def scales(self, metric: str) -> Array:
        """Return what errors of the signals are relative to, (o,)."""
        return np.where(self.sizes > 0.0, self.sizes, scales(metric, self.signals))

    def outcome(self) -> tuple[Any, dict[str, Any]]:
        """Return result and summary of the run."""
        return collect(self.spec, self.prepared.measured, self.finished, self.cpu)


def tried(
    spec: RunSpec,
    plan: Plan,
    model: Mapping[str, Rich],
    check: Mapping[str, Rich],
    names: list[str],
    quiet: npt.NDArray[np.bool_] | None = None,
) -> Trial:
    """Run a plan; `quiet` (o,) are the signals that are rounding by the indicators.

    Raises
    ------
    InputError
        The model of the plan cannot be assembled.
    """
    begin = work_s()
    own = planned(spec, plan, model, check)
    prepared = prepare(own.mechanism, own.packages)
    finished = complete(prepared)
    solution = finished.solution
    recording = Recording(finished.model, solution.t, solution.y)
    compared = relatives(names, own.mechanism, prepared.built, solution.y[0])
    measured = {n: s.values(recording) for n, s in compared.sensors(prepared.built).items()}
    signals, sizes = compared.judged(measured, plan.rtol, quiet)
    cpu = work_s() - begin
    whole = solution.status == "finished"
    return Trial(plan, own, prepared, finished, signals, sizes, whole, cpu)


def attempted(
    spec: RunSpec,
    plan: Plan,
    model: Mapping[str, Rich],
    check: Mapping[str, Rich],
    names: list[str],
    quiet: npt.NDArray[np.bool_] | None = None,
) -> Trial | None:
    """Run a plan, as `tried`; None if its model cannot be assembled."""
    try:
        return tried(spec, plan, model, check, names, quiet)
    except InputError:
        return None


def distance(metric: str, one: Trial, two: Trial) -> Array:
    """Return the difference (o,) of the signals of two runs, of the largest value of the second.

    Infinite if one of them ended early.
    """
    if not (one.complete and two.complete):
        return np.full(len(two.signals), np.inf)
    return difference(metric, one.signals, two.signals) / two.scales(metric)
