"""Sensitivities of a run of a case: from its table to result.vtkhdf, and as text."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...package.common.files import refuse_foreign
from ...report.table import aligned
from ...results import Derivative, RunResult, write_result, write_summary
from ..modes.state import spec_of_run
from .execution import with_sensitivities
from .parameters import design_parameter, parameter_of, with_parameters

RESULT, SUMMARY = "result.vtkhdf", "summary.json"


def compute_sensitivities(
    table: dict[str, Any],
    file: Path,
    run: str,
    keys: Sequence[str],
    *,
    build: Path,
    packages: Path | None = None,
    coarse: bool = False,
    progress: bool = False,
) -> tuple[RunResult, dict[str, object]]:
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
    if not keys:
        raise InputError("--of: expected at least one key of a number, such as gravity.2")
    dotted = [key for key in keys if "." in key]
    case, members = with_parameters(table, file, run, dotted, coarse=coarse)
    spec = spec_of_run(case, run, build, packages)
    numbers = {member[0]: parameter_of(spec, *member) for member in members}
    found = [numbers.get(key) or design_parameter(spec, key) for key in keys]
    return with_sensitivities(spec, found, progress=progress)


def write_sensitivities(folder: Path, result: RunResult, summary: dict[str, object]) -> list[str]:
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
