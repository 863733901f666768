"""Build report.html, one page without other files or network, and figures on request."""

import hashlib
import importlib.metadata
import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import cache
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..math.disk_cache import file_sha256, sources_sha256
from ..package.common.files import kept_table, write_text
from ..results import RunResult, Signal
from ..system.interrupts import ignore, shielded
from ..system.platform import cores, processes
from .bodies import fatigue_section, masses_section, modes_section, strength_section, worst
from .case_figures import (
    draw_balance,
    draw_comparison,
    draw_exposure,
    draw_motion,
    draw_orbit,
    draw_spectrum,
)
from .design.page import design_sections, study_files
from .fidelity import fidelity_section, ladder_file, with_ladder
from .inline import NUMBERS as HISTORIES
from .inline import Blob, document, histories, json_for_script, markup, script
from .report_data import Comparison, Story, comparisons, read_story
from .scene import NUMBERS, scene
from .sections import READING, banner, doubts, inputs_section, outcomes, section, signals_section
from .style import house_style


def view(left_out: list[str]) -> str:
    """Return the section with the mechanism in motion: view.html, which script/viewer.js fills.

    left_out : titles of runs without animation, for lack of space
    """
    names = escape(", ".join(left_out))
    note = f"<p class='note'>Without animation, to keep the page small: {names}.</p>"
    return section("view", "Motion", markup(), note if left_out else "")


LIMIT = 2_900_000  # bytes of a page that can be mailed
LINES = 8  # of a plot of sensitivities


def page(
    title: str,
    stories: list[Story],
    comparisons: list[Comparison],
    designs: Sequence[str] = (),
    reload_s: int = 0,
) -> str:
    """Return the page as HTML; the data of all plots and of the animation are embedded.

    Longer histories keep their extremes only; runs that do not fit into LIMIT have no animation.

    Parameters
    ----------
    title : title of the case
    stories : runs of the case, with results and summary
    comparisons : figures of the case
    designs : sections on studies of designs, as HTML
    reload_s : time after which the page is read again [s]; 0: never
    """
    blob = Blob()
    runs = [_run(blob, story, HISTORIES // len(stories)) for story in stories]
    index = {
        "title": title,
        "case": stories[0].result.case,
        "runs": runs,
        "figures": [c._asdict() for c in comparisons],
    }
    before = [
        _header(title, banner(stories)),
        "<noscript><p>Plots and animation need JavaScript. The tables below are complete; "
        "<code>plymotion report FOLDER --figures</code> draws the plots as PNG files.</p>"
        "</noscript>",
        "<main>",
    ]
    after = [
        section("plots", "Plots", "<div id='plot-list'></div>"),
        strength_section(stories),
        fatigue_section(stories),
        signals_section(stories),
        doubts(stories),
        outcomes(stories),
        *designs,
        fidelity_section(stories),
        modes_section(stories),
        masses_section(stories),
        inputs_section(stories),
        READING,
        "</main>",
    ]

    def whole(moving: str) -> str:
        return _with_data(title, [*before, moving, *after], index, blob, reload_s)

    still = len(whole(view([story.title for story in stories])).encode("utf-8"))
    left_out = _animate(blob, stories, runs, LIMIT - still)
    return whole(view(left_out) if any(run["scene"] for run in runs) else "")


def _with_data(
    title: str, body: Sequence[str], index: Mapping[str, object], blob: Blob, reload_s: int = 0
) -> str:
    arrays = json_for_script({**index, "arrays": blob.index})
    return document(
        title,
        "\n".join(body)
        + f"<script type='application/json' id='index'>{arrays}</script>"
        + f"<script type='text/plain' id='arrays'>{blob.text()}</script>"
        + f"<script>{script()}</script>",
        reload_s,
    )


def sensitivity_page(result: RunResult) -> str:
    """Return a page with a plot for each signal: value times derivative over time, by parameter.

    Parameters
    ----------
    result : with derivatives by parameters; of a parameter that is 0 the derivative itself is shown
    """
    lines: dict[str, list[Signal]] = {}
    figures = []
    for signal in result.signals:
        every = (one for one in result.sensitivities if one.signal == signal.name)
        own = [(one.parameter, one.values * (one.value or 1.0)) for one in every]
        own = sorted(own, key=lambda line: -float(np.nanmean(line[1] ** 2)))[:LINES]
        for key, values in own:
            lines.setdefault(key, []).append(replace(signal, values=values))
        if own:
            shown = {"title": signal.description or signal.name, "signal": signal.name}
            figures.append({**shown, "runs": [key for key, _ in own]})
    blob, title = Blob(), f"{result.case}, {result.run}: sensitivities"
    runs = [
        {"name": key, "title": key, "stopped": False, "scene": None, "worst": []}
        | histories(
            blob, replace(result, signals=tuple(of_key)), HISTORIES // len(lines), verified=False
        )
        for key, of_key in lines.items()
    ]
    words = "<p>Value times derivative of each signal by the most effective parameters, at most "
    words += f"{LINES}</p>"
    plots = section("plots", "Plots", "<div id='plot-list'></div>")
    index = {"title": title, "case": result.case, "runs": runs, "figures": figures}
    return _with_data(title, [_header(title, words), "<main>", plots, "</main>"], index, blob)


def _animate(
    blob: Blob, stories: list[Story], runs: list[dict[str, object]], room: int
) -> list[str]:
    """Give an animation to the first runs, as many as fit into `room` bytes.

    Returns the titles of the others.
    """
    empty = len(blob.text())
    size = 0
    for k, (story, run) in enumerate(zip(stories, runs, strict=True)):
        undo, known = blob.mark(), len(blob.index)
        run["scene"] = scene(blob, story, NUMBERS // len(stories))
        size += len(json_for_script([run["scene"], blob.index[known:]]))
        if size + len(blob.text()) - empty > room:
            undo()
            run["scene"] = None
            return [each.title for each in stories[k:]]
    return []


def _header(title: str, words: str) -> str:
    return (
        f"<header><div><h1>{escape(title)}</h1>{words}</div>"
        "<div class='tools'><button type='button' id='theme'>dark</button>"
        "<button type='button' id='print'>print</button></div></header>"
    )


def _run(blob: Blob, story: Story, share: int) -> dict[str, object]:
    """Return what the page needs of a run, without animation; `share` as of `histories`."""
    return {
        "name": story.name,
        "title": story.title,
        "stopped": story.stopped,
        **histories(blob, story.result, share),
        "scene": None,
        "worst": worst(story),
    }


# Draw the figures of a report: those out of date only, two or more at a time.

FORMATS = ("png", "svg", "pdf")
KEYS = "figures.json"  # digest of what each figure was drawn from, by path
FEW = 3  # figures that do not pay for a second process


class Drawing(NamedTuple):
    """A figure to draw: `draw(path, *arguments)`."""

    path: Path
    draw: Callable[..., Path]
    arguments: tuple[Any, ...]
    content: str  # digest of the data that it shows


def draw_all(folder: Path, drawings: Sequence[Drawing]) -> None:
    """Draw figures whose data, titles or sources have changed, or that are missing.

    On as many processes as there are cores. `folder` keeps the digests.
    """
    before = kept_table(folder / KEYS)
    now = {str(d.path.relative_to(folder)): _key(d) for d in drawings}
    stale = [
        d
        for d, (name, key) in zip(drawings, now.items(), strict=True)
        if before.get(name) != key or not _there(d.path)
    ]
    if stale:
        with house_style():  # also reports that matplotlib is missing
            count = min(cores(), len(stale)) if len(stale) > FEW else 1
            if count > 1:
                with processes(count, ignore) as pool:
                    try:
                        with shielded():  # processes start in `map`
                            drawn = pool.map(_draw, stale)
                        for _ in drawn:
                            pass
                    finally:  # after a signal the others are not begun
                        pool.shutdown(cancel_futures=True)
            else:
                for drawing in stale:
                    _draw(drawing)
    _write_keys(folder / KEYS, now)


def drawn_before(folder: Path) -> set[str]:
    """Return the formats of figures that draw_all has left in a folder."""
    there = [Path(name) for name in kept_table(folder / KEYS) if (folder / name).is_file()]
    return {file.suffix[1:] for file in there} & set(FORMATS)


def _there(file: Path) -> bool:
    """Return whether there is a file; a full disk or a lost machine may leave an empty one."""
    return file.is_file() and file.stat().st_size > 0


def _write_keys(file: Path, keys: dict[str, str]) -> None:
    write_text(file, json.dumps(keys, indent=1) + "\n")


def _draw(drawing: Drawing) -> None:
    with house_style():
        drawing.draw(drawing.path, *drawing.arguments)


def _key(drawing: Drawing) -> str:
    """Digest of a figure's data, of the code that draws it and of matplotlib's version."""
    hasher = hashlib.sha256(drawing.content.encode())
    hasher.update(drawing.draw.__name__.encode())
    hasher.update(version().encode())
    hasher.update(sources_sha256("solver/report").encode())
    return hasher.hexdigest()


@cache
def version() -> str:
    """Version of matplotlib; none without it."""
    try:
        return importlib.metadata.version("matplotlib")
    except importlib.metadata.PackageNotFoundError:
        return ""


PAGE = "report.html"


def make_report(
    case_dir: Path,
    runs: list[str],
    case: Mapping[str, Any] | None = None,
    *,
    figures: bool = False,
    formats: Collection[str] = ("png",),
    reload_s: int = 0,
) -> Path:
    """Write report.html of a case, and figures on request; return the path of the page.

    Parameters
    ----------
    case_dir : build/<case>, holding <run>/summary.json and <run>/result.vtkhdf
    runs : names of the runs to show, in this order
    case : the content of case.json. Used keys: `title`; `runs`, a
        title by name; `figures`, by name {"title", "signal", "runs"}. Signals that no figure
        shows are drawn for all runs.
    figures : draw <figure>.png into case_dir, motion.png and balance.png into each run's
        folder, and strength.png where plies have strengths. A folder that has such figures
        keeps them up to date without this argument.
    formats : of these figures, some of FORMATS
    reload_s : time after which the browser reads the page again [s]; 0: never

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
    drawn_as = drawn_before(case_dir) | (set(formats) if figures else set())
    digests = {run: _result_sha256(case_dir, run) for run in runs}
    key = _content(case_dir, runs, case, digests, sorted(drawn_as))
    known = kept_table(case_dir / KEYS)
    # The page and all figures were made from data of this digest, and are there.
    if known.get(PAGE) == key and all(_there(case_dir / name) for name in known):
        return target
    titles = case.get("runs", {})
    figures_of = (case.get("figures") or {}).values()
    drawn = {f[key] for f in figures_of for key in ("signal", "against") if f.get(key)}
    read = (read_story(case_dir, r, str(titles.get(r) or r), digests[r], drawn) for r in runs)
    stories = [with_ladder(case_dir, story) for story in read]
    shown = comparisons(case, stories)
    by_name = {story.name: story for story in stories}
    for wanted in shown:
        for run in wanted.runs:
            for name in filter(None, (wanted.signal, wanted.against)):
                by_name[run].signal(name)
    if drawn_as:
        drawings = _drawings(case_dir, stories, shown)
        same = [
            [d._replace(path=d.path.with_suffix(f".{form}")) for form in drawn_as] for d in drawings
        ]
        draw_all(case_dir, [drawing for each in same for drawing in each])
    title = str(case.get("title") or stories[0].result.case)
    write_text(target, page(title, stories, shown, design_sections(case_dir), reload_s))
    # After its figures: `draw_all` writes the digests of figures alone.
    _write_keys(case_dir / KEYS, kept_table(case_dir / KEYS) | {PAGE: key})
    return target


def _drawings(case_dir: Path, stories: list[Story], shown: list[Comparison]) -> list[Drawing]:
    """Return the figures of the case, then those of each run."""
    by_name = {story.name: story for story in stories}
    compared = []
    for wanted in shown:
        chosen = [by_name[run] for run in wanted.runs]
        content = repr((wanted, [story.content for story in chosen]))
        file = case_dir / f"{wanted.name}.png"
        draw = draw_orbit if wanted.against else draw_comparison
        draw = draw_spectrum if wanted.spectrum else draw
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
    case: Mapping[str, object],
    results: dict[str, str],
    formats: list[str],
) -> str:
    """Digest of all that the page and the figures show, and of the files that make them.

    results : digest of result.vtkhdf, by run; formats : of the figures
    """
    hasher = hashlib.sha256(
        json.dumps([runs, case, results, formats, version() if formats else ""]).encode()
    )
    hasher.update(sources_sha256("solver/report").encode())
    for file in study_files(case_dir):
        hasher.update(file_sha256(file).encode())
    for run in runs:
        own = case_dir / run / "summary.json", case_dir / "runs" / f"{run}.json"
        for file in (*own, ladder_file(case_dir, run)):
            if file.is_file():
                hasher.update(file_sha256(file).encode())
    return hasher.hexdigest()


def _of_run(
    case_dir: Path, story: Story, name: str, draw: Callable[[Path, Story], Path]
) -> Drawing:
    return Drawing(case_dir / story.name / f"{name}.png", draw, (story,), story.content)
