"""Report of the finished runs of a case folder, as text for the screen."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from ...errors import InputError
from ...results import read_result, read_summary


def run_report(options: argparse.Namespace) -> int:
    """Write the report of a folder and print the table of its runs."""
    print(report_case(options.folder, figures=options.figures, glb=options.glb, vtk=options.vtk))
    return 0


def report_case(
    folder: Path,
    runs: Sequence[str] | None = None,
    *,
    figures: bool = False,
    glb: bool = False,
    vtk: bool = False,
) -> str:
    """Write report.html of a folder that `check` wrote; return a table of its runs.

    Parameters
    ----------
    runs : names of finished runs; None: all that have a summary
    figures : draw the figures as PNG files too
    glb, vtk : write motion.glb, motion.vtkhdf of each run too

    Raises
    ------
    InputError
        Not the folder of a case; no finished run; figures without matplotlib.
    """
    from ...report import make_report, summary_table, write_glb, write_vtk
    from ...report.story import case_table

    try:
        case = case_table(json.loads((folder / "case.json").read_text(encoding="utf-8")))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(
            f"{folder}: no case.json ({error}); expected the folder of a case"
        ) from error
    if runs is None:
        runs = [r for r in case["runs"] if (folder / r / "summary.json").is_file()]
    if not runs:
        raise InputError(f"{folder}: no finished run; expected <run>/summary.json")
    page = make_report(folder, list(runs), case, figures=figures)
    summaries = [read_summary(folder / run / "summary.json") for run in runs]
    text = f"{summary_table(summaries)}\nReport: {page}"
    for run in runs:
        result = folder / run / "result.vtkhdf"
        if glb:
            text += f"\nAnimation: {write_glb(folder / run / 'motion.glb', read_result(result))}"
        if vtk:
            text += f"\nAnimation: {write_vtk(folder / run / 'motion.vtkhdf', result)}"
    return text
