"""Build figures and report.html from the files of finished runs."""

import hashlib
import importlib.metadata
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..package.common.file_digests import files_sha256
from ..package.common.temporary import write_text
from .balance import draw_balance
from .comparison import draw_comparison
from .drawings import Drawing, draw_all, is_up_to_date, remember, sources
from .exposure import draw_exposure
from .fidelity import ladder_file, with_ladder
from .motion import draw_motion
from .page import page
from .spectrum import draw_spectrum
from .story import Story, comparisons, read_story

PAGE = "report.html"


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
    strength.png too where plies have strengths, and report.html last. What shows the same as
    before is not made again.

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
    target = case_dir / PAGE
    key = _content(case_dir, runs, case)
    if is_up_to_date(case_dir, PAGE, key):
        return target
    titles = case.get("runs", {})
    stories = [read_story(case_dir, run, str(titles.get(run) or run)) for run in runs]
    stories = [with_ladder(case_dir, story) for story in stories]
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
    write_text(target, page(title, stories, shown))
    remember(case_dir, PAGE, key)
    return target


def _content(case_dir: Path, runs: list[str], case: dict[str, Any]) -> str:
    """Digest of all that the page and the figures show, and of the files that make them."""
    found = hashlib.sha256(json.dumps([runs, case]).encode())
    found.update(importlib.metadata.version("matplotlib").encode())
    found.update(sources("**/*"))
    for run in runs:
        names = (f"{run}/summary.json", f"{run}/result.vtkhdf", f"runs/{run}.json")
        files = {name: case_dir / name for name in names if (case_dir / name).is_file()}
        ladder = ladder_file(case_dir, run)
        files |= {ladder.name: ladder} if ladder.is_file() else {}
        found.update(files_sha256(files).encode())
    return found.hexdigest()


def _of_run(
    case_dir: Path, story: Story, name: str, draw: Callable[[Path, Story], Path]
) -> Drawing:
    return Drawing(case_dir / story.name / f"{name}.png", draw, (story,), story.content)
