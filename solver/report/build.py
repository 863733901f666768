"""Build report.html, and figures on request, from the files of finished runs."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..math.digests import file_sha256, sources_sha256
from ..package.common.temporary import write_text
from .balance import draw_balance
from .comparison import draw_comparison
from .drawings import Drawing, draw_all, drawn_before, is_up_to_date, remember, version
from .exposure import draw_exposure
from .fidelity import ladder_file, with_ladder
from .motion import draw_motion
from .page import page
from .spectrum import draw_spectrum
from .story import Comparison, Story, comparisons, read_story

PAGE = "report.html"


def make_report(
    case_dir: Path,
    runs: list[str],
    case: dict[str, Any] | None = None,
    *,
    figures: bool = False,
) -> Path:
    """Write report.html of a case, and figures on request; return the path of the page.

    Parameters
    ----------
    case_dir : build/<case>, holding <run>/summary.json and <run>/result.vtkhdf
    runs : names of the runs to show, in this order
    case : the content of case.json. Used keys: `title`; `runs`, a
        title by name; `figures`, by name {"title", "signal", "runs"}. Without
        figures, each signal is drawn for all runs.
    figures : draw <figure>.png into case_dir, motion.png and balance.png into each run's
        folder, and strength.png where plies have strengths. A folder that has such figures
        keeps them up to date without this argument.

    What shows the same as before is not made again.

    Raises
    ------
    ResultError
        A run whose files are missing or damaged.
    InputError
        No runs, a figure of a signal that does not exist, figures without matplotlib.
    """
    case_dir, case = Path(case_dir), case or {}
    if not runs:
        raise InputError(f"{case_dir}: no runs to report on; expected at least one")
    target = case_dir / PAGE
    figures = figures or drawn_before(case_dir)
    digests = {run: _result_sha256(case_dir, run) for run in runs}
    key = _content(case_dir, runs, case, digests, figures=figures)
    if is_up_to_date(case_dir, PAGE, key):
        return target
    titles = case.get("runs", {})
    drawn = {figure["signal"] for figure in (case.get("figures") or {}).values()}
    stories = [
        read_story(case_dir, run, str(titles.get(run) or run), digests[run], drawn) for run in runs
    ]
    stories = [with_ladder(case_dir, story) for story in stories]
    shown = comparisons(case, stories)
    by_name = {story.name: story for story in stories}
    for wanted in shown:
        for run in wanted.runs:
            by_name[run].signal(wanted.signal)
    if figures:
        draw_all(case_dir, _drawings(case_dir, stories, shown))
    title = str(case.get("title") or stories[0].result.case)
    write_text(target, page(title, stories, shown))
    remember(case_dir, PAGE, key)
    return target


def _drawings(case_dir: Path, stories: list[Story], shown: list[Comparison]) -> list[Drawing]:
    """Return the figures of the case, then those of each run."""
    by_name = {story.name: story for story in stories}
    compared = []
    for wanted in shown:
        chosen = [by_name[run] for run in wanted.runs]
        content = repr((wanted, [story.content for story in chosen]))
        file = case_dir / f"{wanted.name}.png"
        draw = draw_spectrum if wanted.spectrum else draw_comparison
        compared.append(Drawing(file, draw, (wanted, chosen), content))
    motions = [_of_run(case_dir, story, "motion", draw_motion) for story in stories]
    balances = [_of_run(case_dir, story, "balance", draw_balance) for story in stories]
    strong = [story for story in stories if story.summary.get("strength")]
    strengths = [_of_run(case_dir, story, "strength", draw_exposure) for story in strong]
    return [*compared, *motions, *balances, *strengths]


def _result_sha256(case_dir: Path, run: str) -> str:
    """Digest of the result of a run; nothing without a result, which read_story reports."""
    file = case_dir / run / "result.vtkhdf"
    return file_sha256(file) if file.is_file() else ""


def _content(
    case_dir: Path,
    runs: list[str],
    case: dict[str, Any],
    results: dict[str, str],
    *,
    figures: bool,
) -> str:
    """Digest of all that the page and the figures show, and of the files that make them.

    results : digest of result.vtkhdf, by run
    """
    found = hashlib.sha256(json.dumps([runs, case, results, version() if figures else ""]).encode())
    found.update(sources_sha256("solver/report").encode())
    for run in runs:
        own = case_dir / run / "summary.json", case_dir / "runs" / f"{run}.json"
        for file in (*own, ladder_file(case_dir, run)):
            if file.is_file():
                found.update(file_sha256(file).encode())
    return found.hexdigest()


def _of_run(
    case_dir: Path, story: Story, name: str, draw: Callable[[Path, Story], Path]
) -> Drawing:
    return Drawing(case_dir / story.name / f"{name}.png", draw, (story,), story.content)
