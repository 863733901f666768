"""The command `plymotion plan`: the model of a run, chosen by its accuracy, and its chart."""

import argparse
import json
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs.case.load import load_case
from ..inputs.case.record import case_file
from ..package.common.files import refuse_foreign, write_text
from ..report.fidelity import ladder_file
from ..report.style import GREY, INK, WARNING, Canvas, colour, house_style
from ..report.table import aligned, json_text
from ..run.inputs import plan_file
from ..studies.cases import build_folder, chosen_run
from ..studies.exit_codes import INCOMPLETE
from ..studies.fidelity.answer import answer_text, entry
from ..studies.fidelity.checked_run import answered
from ..studies.fidelity.ladder import Ladder, Rung, ladder
from ..workers.packages import prepared

# The command `plymotion plan`: the model of a run, chosen by its accuracy.


def run_file_of(options: argparse.Namespace) -> Path:
    """Check a case, write its run files, build the packages, and return one run file.

    Raises
    ------
    InputError
        The case is wrong, has no such run, or its run has no [fidelity]; a package cannot be
        built.
    """
    file = case_file(options.case)
    case = load_case(file, sweeps=())
    run = chosen_run(case, options.run)
    if case.runs[run].fidelity is None:
        raise InputError(
            f"{file}: run {run} has no [fidelity]: expected a table with accuracy and "
            "signals (docs/fidelity.md)"
        )
    folder: Path = options.out or build_folder(file)
    return prepared(case, folder, f"runs/{run}.json", options.packages)


def run_plan(options: argparse.Namespace) -> int:
    """Print the plan of a run, or its chart; return the exit code."""
    if options.chart or options.figure:
        if options.json or options.no_check:
            given = "--json" if options.json else "--no-check"
            raise InputError(f"{given}: expected without --chart")
        return run_chart(options)
    answer = answered(run_file_of(options), again=True, check=not options.no_check)
    if options.json:
        print(json_text(entry(answer)))
    else:
        print(answer_text(answer))
    return INCOMPLETE if answer.verdict == "not met" else 0


# `plymotion plan --chart`: error against CPU time of the models of one run.

NAMES = 6.5  # size of the names of models [pt]


def run_chart(options: argparse.Namespace) -> int:
    """Draw the chart of a run and print its table; return the exit code.

    Raises
    ------
    InputError
        The model of the plan or its check could not run.
    """
    file = run_file_of(options)
    figure = options.figure or plan_file(file).with_suffix(".png")
    for path in (figure, ladder_file(file.parent.parent, file.stem)):
        refuse_foreign(path)  # before the work
    answer = answered(file)
    if answer.trial is None or answer.check is None or answer.estimate is None:
        raise InputError(f"{file}: no chart without a check: {answer.reason}")
    chart = ladder(answer)
    rows = [["CPU time", "error", "model"]]
    for rung in (*chart.front(), chart.chosen, chart.check):
        rows.append([f"{rung.cpu:.3f} s", f"{rung.error:.1e}", rung.name])
    print(aligned(rows, (2,), head=1, rule=False))
    data = {**chart.entry(), "plan": answer.plan.table()}
    write_text(ladder_file(file.parent.parent, answer.spec.run), json.dumps(data, indent=1) + "\n")
    title = f"{answer.spec.case}, {answer.spec.run}: {', '.join(answer.names)}"
    print(f"Chart: {draw_ladder(figure, chart, title)}")
    return 0


def draw_ladder(path: Path, chart: Ladder, title: str) -> Path:
    """Draw error against CPU time: all models, their front, the chosen one, the check.

    Parameters
    ----------
    path : file of the picture
    chart : models with their errors and CPU times
    title : title of the picture
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with house_style():
        canvas = Canvas(7.5, 4.6)
        (axis,) = canvas.panels(1, 1)
        shown, front = (
            [rung for rung in rungs if rung.error > 0.0] for rungs in (chart.rungs, chart.front())
        )
        estimate = Rung("", chart.chosen.cpu, chart.estimate)
        for label, rungs, mark, ink, size in (
            ("models", shown, "o", GREY, 4),
            ("front", front, "-", GREY, 0),
            ("chosen", [chart.chosen], "D", colour(0), 8),
            ("estimate", [estimate], "_", colour(0), 16),
            ("check, delivered", [chart.check], "s", colour(2), 8),
        ):
            x, y = [rung.cpu for rung in rungs], [rung.error for rung in rungs]
            axis.loglog(x, y, mark, color=ink, markersize=size, linewidth=1.0, label=label)
        axis.axhline(chart.asked, color=WARNING, linewidth=1.0)
        axis.text(
            0.99,
            chart.asked,
            "asked",
            color=WARNING,
            ha="right",
            va="bottom",
            fontsize=8,
            transform=axis.get_yaxis_transform(),
        )
        axis.set(xlabel="CPU time of a run [s]", ylabel="error / largest value")
        axis.set_title(title, color=INK)
        axis.legend(loc="lower left", markerscale=0.7)  # the front goes from upper left down
        _name(axis, front)
        return canvas.save(path)


def _name(axis: Any, rungs: list[Rung]) -> None:
    """Write the names of models beside their points, as far as they do not cover each other."""
    points = 72.0 / axis.figure.dpi
    known: list[tuple[float, float, float]] = []
    for rung in sorted(rungs, key=lambda rung: rung.cpu):
        x, y = points * axis.transData.transform((rung.cpu, rung.error))
        end = x + 0.6 * NAMES * len(rung.name)
        if all(abs(y - height) > 1.3 * NAMES or x > last or end < at for at, last, height in known):
            known.append((x, end, y))
            axis.annotate(
                rung.name,
                (rung.cpu, rung.error),
                (4, 4),
                textcoords="offset points",
                fontsize=NAMES,
            )
