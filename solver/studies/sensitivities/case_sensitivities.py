"""Sensitivities of a run as files and as text."""

from pathlib import Path

import numpy as np

from ...package.common.files import refuse_foreign, write_text
from ...report.report_page import PAGE, sensitivity_page
from ...report.table import aligned
from ...results import Derivative, RunResult, Summary, write_result, write_summary

RESULT, SUMMARY = "result.vtkhdf", "summary.json"


def write_sensitivities(folder: Path, result: RunResult, summary: Summary) -> list[str]:
    """Write result.vtkhdf, summary.json and, of signals, report.html; return their names.

    Parameters
    ----------
    folder : is made if it is not there
    result : with the derivatives of signals; none: the summary has those of an objective
    summary : of the run

    Raises
    ------
    InputError
        A file of these names that another program wrote.
    """
    for name in (SUMMARY, PAGE):
        refuse_foreign(folder / name)
    folder.mkdir(parents=True, exist_ok=True)
    write_result(folder / RESULT, result)
    write_summary(folder / SUMMARY, summary)
    if not result.sensitivities:  # those of an objective
        (folder / PAGE).unlink(missing_ok=True)
        return [RESULT, SUMMARY]
    write_text(folder / PAGE, sensitivity_page(result))
    return [RESULT, SUMMARY, PAGE]


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
