"""The gradient of one number of a run by many parameters, by the adjoint of its motion."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from ...dynamics.analysis.recovery import Recording
from ...errors import InputError, refuse
from ...inputs.case.design import unknown_subject
from ...inputs.case.tables.design_keys import Quantity
from ...inputs.common.input_table import validated
from ...report.table import aligned
from ...results import RunResult, Summary
from ...run.outcome import collect
from ...run.preparation import integrated, prepare
from ..sensitivities.case_sensitivities import asked_of
from ..sensitivities.differentiated_run import Trace
from .exact import Traced, by_adjoint
from .measures import Made, measure_of

OBJECTIVE: Final = "objective"  # of summary.json


def compute_gradient(
    table: dict[str, object],
    file: Path,
    run: str,
    keys: Sequence[str],
    objective: Mapping[str, Any],
    *,
    build: Path,
    packages: Path | None = None,
    coarse: bool = False,
) -> tuple[RunResult, Summary]:
    """Return result and summary of a run; `objective` of the summary has value and derivatives.

    Parameters
    ----------
    objective : a quantity of a run as in `minimise` of a study
    table, file, run, keys, build, packages, coarse : as for `compute_sensitivities`

    Raises
    ------
    InputError
        As `compute_sensitivities`; an objective that a run does not have.
    """
    quantity = validated(Quantity, dict(objective), f"{file}: objective")
    measure = measure_of(quantity)
    if not measure.runs:
        raise InputError(f"objective: {quantity.words()}: expected a signal, strength or energy")
    spec, parameters, shares = asked_of(table, file, run, keys, build, packages, coarse=coarse)
    refuse(unknown_subject("objective", quantity, spec.mechanism))
    prepared = prepare(spec.mechanism, spec.packages)
    trace = Trace(prepared)
    finished = integrated(prepared, trace, stages=True)
    solution = finished.solution
    if solution.status == "interrupted":
        raise KeyboardInterrupt
    if solution.status != "finished":
        raise InputError(f"{run}: an objective needs a run that finishes: {solution.message}")
    recording = Recording(prepared.model, solution.t, np.asarray(solution.y[:]))
    made = Made(spec, finished, prepared.measured, recording)
    value = measure.shown(measure.raw(made), made.t)
    kept = [quantity.name] if quantity.subject == "signal" else []
    traced = Traced(prepared, finished, trace, kept)
    rates = by_adjoint(traced, parameters, [measure], made)[0][0]
    if quantity.subject == "strength":  # the values are exposures
        rates = -rates * value**2
    slopes = rates if shares is None else rates @ shares
    result, summary = collect(spec, prepared.measured, finished, 0.0)
    summary[OBJECTIVE] = {
        "words": quantity.words(),
        "value": value,
        "unit": measure.unit,
        "derivatives": dict(zip(keys, slopes.tolist(), strict=True)),
    }
    return result, summary


def gradient_table(summary: Summary) -> str:
    """Return the value of an objective and its derivatives, the largest first."""
    gradient = summary[OBJECTIVE]
    rows = [[name, f"{rate:.6g}"] for name, rate in gradient["derivatives"].items()]
    rows.sort(key=lambda row: -abs(float(row[1])))
    head = f"{gradient['words']} = {gradient['value']:.6g} {gradient['unit']}"
    return f"{head}\n{aligned([['parameter', 'derivative'], ['', ''], *rows], left=(0, 1))}"
