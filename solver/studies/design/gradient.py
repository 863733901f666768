"""Derivatives of a run by numbers of its case and parameters of its design: of all signals by the
tangent of its motion, of one number by the adjoint."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from ...dynamics.analysis.recovery import Recording
from ...errors import InputError, refuse
from ...inputs.case.design import unknown_subject
from ...inputs.case.tables.design_keys import Quantity
from ...inputs.common.input_table import validated
from ...report.table import aligned
from ...results import Derivative, RunResult, Summary
from ...run.outcome import collect
from ...run.preparation import integrated, prepare
from ..sensitivities.differentiated_run import Trace, with_sensitivities
from .asked import asked_of
from .exact import Traced, by_adjoint
from .measures import Made, measure_of

OBJECTIVE: Final = "objective"  # of summary.json


def compute_sensitivities(
    table: dict[str, object],
    file: Path,
    run: str,
    keys: Sequence[str],
    *,
    build: Path,
    packages: Path | None = None,
    coarse: bool = False,
    progress: bool = False,
) -> tuple[RunResult, Summary]:
    """Return result and summary of a run of a case, with its derivatives by the numbers at `keys`.

    Parameters
    ----------
    keys : of numbers, names of `[design.parameters]`, or of parameters by which packages have
        derivatives; none: all of `[design.parameters]` with numbers
    table, file : content of a case file, and its name for messages and relative paths
    build : folder of the case, where packages are built unless `packages` has them

    Raises
    ------
    InputError, PackageError
        A mistake in the case; a key that is none of a number of the mechanism; what has no
        derivative.
    """
    asked = asked_of(table, file, run, keys, build, packages, coarse=coarse)
    spec, parameters, keys, shares = asked
    result, summary = with_sensitivities(spec, parameters, progress=progress)
    if shares is None:
        return result, summary
    derivatives = list[Derivative]()
    for signal in result.signals:
        own = [one for one in result.sensitivities if one.signal == signal.name]
        rates = np.stack([one.values for one in own], axis=-1) @ shares
        for k, key in enumerate(keys):
            number = next((p for p in parameters if p.name == key), None)
            unit, value = (number.unit, number.value) if number else ("", 0.0)
            unit = f"({signal.unit})/({unit})" if unit else signal.unit
            derivatives.append(Derivative(signal.name, key, unit, value, rates[..., k]))
    return replace(result, sensitivities=tuple(derivatives)), summary


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
    asked = asked_of(table, file, run, keys, build, packages, coarse=coarse)
    spec, parameters, keys, shares = asked
    refuse(unknown_subject("objective", quantity, spec.mechanism))
    prepared = prepare(spec.mechanism, spec.packages)
    if quantity.subject == "signal" and quantity.name not in prepared.measured:
        raise InputError(
            f"objective: signal {quantity.name} reads another run, whose derivatives a study has; "
            "expected a signal of this run"
        )
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
