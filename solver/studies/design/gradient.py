"""Derivatives of a run by numbers of its case and parameters of its design: of all signals by the
tangent of its motion, of one number by the adjoint."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from ...dynamics.analysis.recovery import Recording
from ...errors import InputError, few, refuse
from ...inputs.case.design import unknown_subject
from ...inputs.case.tables.design_keys import Quantity
from ...inputs.common.input_table import validated
from ...inputs.common.text_file import Tables
from ...math.arrays import Array
from ...report.table import aligned
from ...results import Derivative, RunResult, Summary
from ...run.inputs import RunSpec
from ...run.outcome import collect
from ...run.preparation import integrated, prepare
from ..modes.state import spec_of_run
from ..sensitivities.differentiated_run import Trace, with_sensitivities
from ..sensitivities.parameters import (
    Parameter,
    combined,
    design_parameter,
    parameter_of,
    with_parameters,
    without_derivatives,
)
from .exact import Traced, by_adjoint
from .measures import Made, measure_of
from .trials import BODIES, StudySpec, Trials

# Parameters by which a run is differentiated: numbers of its case, parameters of its `[design]`,
# and those by which its packages have derivatives.

MANY = 50  # parameters of packages, above which they are combined
OF_DESIGN = "sensitivities"  # the study whose first design has the packages


class Asked(NamedTuple):
    """A run of a case, and by what it is differentiated."""

    table: dict[str, object]  # content of a case file
    file: Path  # its name for messages and relative paths
    run: str
    # of numbers of the mechanism, names of `[design.parameters]`, or parameters of packages; none:
    # all of `[design.parameters]` that are no choice
    keys: Sequence[str]
    build: Path  # folder of the case, where packages are built
    packages: Path | None = None  # folder of packages that are there already; None: they are built
    coarse: bool = False  # bodies have coarse meshes


def _found(asked: Asked) -> tuple[RunSpec, list[Parameter], Sequence[str], Array | None]:
    """Return a run, its parameters, the keys of the derivatives, and shares.

    Many design parameters are replaced by fewer that change the packages in all ways that they do
    (`combined`). Shares (fewer, keys) then say what a parameter has of each key; None otherwise.

    Raises
    ------
    InputError
        A key twice or none; a key that is no number, or has no derivative.
    """
    table, file, run, keys, build, packages, coarse = asked
    if twice := {key for key in keys if list(keys).count(key) > 1}:
        raise InputError(f"--of {few(twice)}: given twice")
    dotted = [key for key in keys if "." in key]
    case, members = with_parameters(table, file, run, dotted, coarse=coarse)
    design = case.top.design.parameters if case.top.design else {}
    known = [name for name, parameter in design.items() if parameter.kind != "choice"]
    keys = keys or known
    if not keys:
        raise InputError("--of: expected at least one key of a number, such as gravity.2")
    designed, shares = [key for key in keys if key in known], None
    if designed:
        spec, of_design = _of_design(table, file, run, designed, build, coarse=coarse)
    else:
        spec, of_design = spec_of_run(case, run, build, packages), []
    names = [key for key in keys if "." not in key and key not in known]
    if len(names) > MANY:
        for name in names:
            if not any(one.name == name for p in spec.packages.values() for one in p.design):
                raise without_derivatives(spec, name, known)
        kept, own = combined([spec], names)
        others = [*(member[0] for member in members), *designed]
        shares = np.zeros((len(others) + len(kept), len(keys)))
        for k, name in enumerate(others):
            shares[k, keys.index(name)] = 1.0
        shares[len(others) :, [keys.index(name) for name in names]] = own
        names = [names[k] for k in kept]
    numbers = [parameter_of(spec, *member) for member in members]
    parameters = [*numbers, *of_design, *(design_parameter(spec, name, known) for name in names)]
    if shares is None:
        parameters.sort(key=lambda parameter: keys.index(parameter.name))
    return spec, parameters, keys, shares


def _of_design(
    table: Tables, file: Path, run: str, names: list[str], build: Path, *, coarse: bool
) -> tuple[RunSpec, list[Parameter]]:
    """Return a run with packages that have derivatives, and its parameters of `[design]`."""
    study = {"run": run, "parameters": names, "minimise": {"mass": "mechanism"}, "rtol": 0.5}
    given = table["design"]
    design = {**given, "studies": {**given.get("studies", {}), OF_DESIGN: study}}
    folder = build / OF_DESIGN / run
    trials = Trials(StudySpec({**table, "design": design}, file, coarse, OF_DESIGN, folder))
    try:
        return trials.differentiable()
    finally:
        shutil.rmtree(folder / BODIES, ignore_errors=True)


OBJECTIVE: Final = "objective"  # of summary.json


def compute_sensitivities(asked: Asked, *, progress: bool = False) -> tuple[RunResult, Summary]:
    """Return result and summary of a run of a case, with its derivatives by the numbers at `keys`.

    Raises
    ------
    InputError, PackageError
        A mistake in the case; a key that is none of a number of the mechanism; what has no
        derivative.
    """
    spec, parameters, keys, shares = _found(asked)
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


def compute_gradient(asked: Asked, objective: Mapping[str, Any]) -> tuple[RunResult, Summary]:
    """Return result and summary of a run; `objective` of the summary has value and derivatives.

    `objective` is a quantity of a run as in `minimise` of a study.

    Raises
    ------
    InputError
        As `compute_sensitivities`; an objective that a run does not have.
    """
    quantity = validated(Quantity, dict(objective), f"{asked.file}: objective")
    measure = measure_of(quantity)
    if not measure.runs:
        raise InputError(f"objective: {quantity.words()}: expected a signal, strength or energy")
    spec, parameters, keys, shares = _found(asked)
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
        raise InputError(f"{asked.run}: an objective needs a run that finishes: {solution.message}")
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
