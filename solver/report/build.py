"""Build figures and report.html from the files of finished runs."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..package.common.temporary import temporary_sibling
from .balance import draw_balance
from .comparison import draw_comparison
from .drawings import Drawing, draw_all
from .exposure import draw_exposure
from .motion import draw_motion
from .page import page
from .spectrum import draw_spectrum
from .story import Story, comparisons, read_story


def make_report(case_dir: Path, runs: list[str], case: dict[str, Any] | None = None) -> Path:
    """Write figures and report.html of a case; return the path of the page.

    Parameters
    ----------
    case_dir : build/<case>, holding <run>/summary.json and <run>/result.vtkhdf
    runs : names of the runs to show, in this order
    case : the content of case.json. Used keys: `title`; `runs`, a
        title by name; `figures`, by name {"title", "signal", "runs"}. Without
        figures, each signal is drawn for all runs.

    Writes <figure>.png into case_dir, motion.png and balance.png into each run's folder,
    strength.png too where plies have strengths, and report.html last. Figures that show the same
    as before are not drawn again.

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
    compared, shown = [], comparisons(case, stories)
    for wanted in shown:
        chosen = [by_name[run] for run in wanted.runs]
        for story in chosen:
            story.signal(wanted.signal)
        content = repr((wanted, [story.content for story in chosen]))
        file = case_dir / f"{wanted.name}.png"
        draw = draw_spectrum if wanted.spectrum else draw_comparison
        compared.append(Drawing(file, draw, (wanted, chosen), content))
    motions = [_of_run(case_dir, story, "motion", draw_motion) for story in stories]
    balances = [_of_run(case_dir, story, "balance", draw_balance) for story in stories]
    strong = [story for story in stories if story.summary.get("strength")]
    strengths = [_of_run(case_dir, story, "strength", draw_exposure) for story in strong]
    draw_all(case_dir, [*compared, *motions, *balances, *strengths])
    title = str(case.get("title") or stories[0].result.case)
    target = case_dir / "report.html"
    with temporary_sibling(target) as temporary:
        text = page(title, stories, shown)
        temporary.write_text(text, encoding="utf-8")
    return target


def _of_run(
    case_dir: Path, story: Story, name: str, draw: Callable[[Path, Story], Path]
) -> Drawing:
    return Drawing(case_dir / story.name / f"{name}.png", draw, (story,), story.content)
