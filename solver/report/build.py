"""Build figures and report.html from the files of finished runs."""

from pathlib import Path
from typing import Any

from ..errors import InputError
from ..package.common.container import temporary_sibling
from .balance import draw_balance
from .comparison import draw_comparison
from .exposure import draw_exposure
from .motion import draw_motion
from .page import page
from .story import comparisons, read_story
from .style import house_style


def make_report(case_dir: Path, runs: list[str], case: dict[str, Any] | None = None) -> Path:
    """Write figures and report.html of a case; return the path of the page.

    Parameters
    ----------
    case_dir : build/<case>, holding <run>/summary.json and <run>/result.vtkhdf
    runs : names of the runs to show, in this order
    case : the content of case.json. Used keys: `title`; `runs`, a
        title by name; `figures`, by name {"title", "signal", "runs"}. Without
        figures, each signal is drawn for all runs.

    Writes <figure>.png into case_dir, motion.png and balance.png into each
    run's folder, strength.png too where plies have strengths, and report.html last.

    Raises
    ------
    ResultError
        A run whose files are missing or damaged.
    InputError
        No runs, a figure of a signal that does not exist, no matplotlib.
    """
    case_dir, case = Path(case_dir), case or {}
    if not runs:
        raise InputError(f"{case_dir}: no runs to report on; expected at least one")
    titles = case.get("runs", {})
    stories = [read_story(case_dir, run, str(titles.get(run) or run)) for run in runs]
    by_name = {story.name: story for story in stories}
    drawn = []
    with house_style():
        for wanted in comparisons(case, stories):
            chosen = [by_name[run] for run in wanted.runs]
            file = case_dir / f"{wanted.name}.png"
            drawn.append((wanted.title, draw_comparison(file, wanted, chosen)))
        motions = [draw_motion(case_dir / s.name / "motion.png", s) for s in stories]
        balances = [draw_balance(case_dir / s.name / "balance.png", s) for s in stories]
        strengths = [
            draw_exposure(case_dir / s.name / "strength.png", s)
            for s in stories
            if s.summary.get("strength")
        ]
    title = str(case.get("title") or stories[0].result.case)
    target = case_dir / "report.html"
    with temporary_sibling(target) as temporary:
        text = page(title, stories, drawn, motions, balances, strengths)
        temporary.write_text(text, encoding="utf-8")
    return target
