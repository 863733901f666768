"""Sensitivities of a run of a case: from its table to result.vtkhdf, and as text."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...math.arrays import Array
from ...package.common.files import refuse_foreign
from ...report.table import aligned
from ...results import Derivative, RunResult, Summary, write_result, write_summary
from ...run.inputs import RunSpec
from ..modes.state import spec_of_run
from .differentiated_run import with_sensitivities
from .parameters import Parameter, combined, design_parameter, parameter_of, with_parameters

RESULT, SUMMARY = "result.vtkhdf", "summary.json"
MANY = 50  # design parameters, above which they are combined


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
    table, file : content of a case file, and its name for messages and relative paths
    build : folder of the case, where packages are built unless `packages` has them

    Raises
    ------
    InputError, PackageError
        A mistake in the case; a key that is none of a number of the mechanism; what has no
        derivative.
    """
    spec, parameters, shares = asked_of(table, file, run, keys, build, packages, coarse=coarse)
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


def asked_of(
    table: dict[str, object],
    file: Path,
    run: str,
    keys: Sequence[str],
    build: Path,
    packages: Path | None,
    *,
    coarse: bool,
) -> tuple[RunSpec, list[Parameter], Array | None]:
    """Return a run and its parameters at `keys`; see `compute_sensitivities`.

    Many design parameters are replaced by fewer that change the packages in all ways that they do
    (`combined`); then the last is (fewer, keys): what a parameter has of each.
    """
    if not keys:
        raise InputError("--of: expected at least one key of a number, such as gravity.2")
    dotted = [key for key in keys if "." in key]
    case, members = with_parameters(table, file, run, dotted, coarse=coarse)
    spec = spec_of_run(case, run, build, packages)
    names = [key for key in keys if "." not in key]
    shares = None
    if len(names) > MANY:
        spec, own = combined(spec, names)
        shares = np.zeros((len(members) + len(own), len(keys)))
        for k, member in enumerate(members):
            shares[k, keys.index(member[0])] = 1.0
        shares[len(members) :, [keys.index(name) for name in names]] = own
        names = [str(k) for k in range(len(own))]
    numbers = [parameter_of(spec, *member) for member in members]
    parameters = [*numbers, *(design_parameter(spec, name) for name in names)]
    if shares is None:
        parameters.sort(key=lambda parameter: keys.index(parameter.name))
    return spec, parameters, shares


def write_sensitivities(folder: Path, result: RunResult, summary: Summary) -> list[str]:
    """Write result.vtkhdf and summary.json into a folder; return their names."""
    refuse_foreign(folder / SUMMARY)
    folder.mkdir(parents=True, exist_ok=True)
    write_result(folder / RESULT, result)
    write_summary(folder / SUMMARY, summary)
    return [RESULT, SUMMARY]


def scaled(one: Derivative) -> tuple[float, float]:
    """Return peak and root mean square of value times derivative: of a relative change by one.

    Of a parameter that is zero: of the derivative itself.
    """
    values = np.abs(one.values[np.isfinite(one.values)]) * (abs(one.value) or 1.0)
    rms = np.sqrt(np.mean(values**2)) if values.size else 0.0
    return float(values.max(initial=0.0)), float(rms)


def sensitivity_table(result: RunResult) -> str:
    """Return a table: for each signal the parameters, the most effective first."""
    rows = [["signal", "parameter", "value", "peak", "rms", "unit"], [""] * 6]
    for signal in result.signals:
        own = [(scaled(one), one) for one in result.sensitivities if one.signal == signal.name]
        for (peak, rms), one in sorted(own, key=lambda item: -item[0][1]):
            unit = signal.unit if one.value else one.unit
            numbers = [f"{x:.4g}" for x in (one.value, peak, rms)]
            rows.append([signal.name, one.parameter, *numbers, unit])
    note = "peak and rms over time of value times derivative (of the derivative where value = 0)"
    return f"{aligned(rows, left=(0, 1, 5))}\n{note}"
