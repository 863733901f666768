"""Data of a case and its runs for the report."""

import hashlib
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError, nearest
from ..math.disk_cache import file_sha256
from ..package.common.files import kept_table
from ..results import ResultError, RunResult, Signal, Summary, read_result, read_summary

# case.json: what the report needs to know of a case.

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")  # of a run, or a figure: part of a file name


def case_table(table: Any) -> Mapping[str, Any]:
    """Return the content of case.json. Raises ValueError if `check` cannot have written it."""
    if not isinstance(table, dict):
        raise ValueError(f"expected a table, found {type(table).__name__}")
    for key in ("runs", "figures"):
        named = table.get(key, {})
        if not isinstance(named, dict) or (key == "runs" and not named):
            raise ValueError(f"key {key}: expected a table of names")
        for name in named:
            if not _NAME.fullmatch(name):
                raise ValueError(f"key {key}: expected letters and digits in {name!r}")
    for name, figure in table.get("figures", {}).items():
        if not (isinstance(figure, dict) and _is_figure(figure)):
            raise ValueError(f"key figures.{name}: expected title, signal and a list of runs")
    return table


def _is_figure(figure: dict[str, object]) -> bool:
    runs = figure.get("runs")
    texts = [figure.get("title"), figure.get("signal"), *(runs if isinstance(runs, list) else [0])]
    return all(isinstance(word, str) for word in texts)


# Data of a run for the report: summary, result and title.

MOST_SIGNALS = 700  # of a run: NUMBERS / FEWEST of inline.py


@dataclass(frozen=True)
class Story:
    """One run of the report."""

    name: str
    title: str
    summary: Summary
    result: RunResult
    content: str = ""  # digest of all that figures show
    inputs: dict[str, object] = field(default_factory=dict)  # mechanism of the run file
    sha256: str = ""  # of result.vtkhdf
    left_out: int = 0  # signals beyond MOST_SIGNALS

    @property
    def stopped(self) -> bool:
        """True if the run ended before its end time."""
        return not self.summary.get("completed", False)

    def signal(self, name: str) -> Signal:
        """Return a signal by name. Raises InputError."""
        if name not in self._signals:
            raise InputError(f"run {self.name}: no signal {name!r}{nearest(name, self._signals)}")
        return self._signals[name]

    def is_ratio(self, name: str) -> bool:
        """Return whether a signal is a strength ratio."""
        signals = self.inputs.get("signals")
        asked = signals.get(name, {}) if isinstance(signals, dict) else {}
        return asked.get("kind") == "strength_ratio" and not asked.get("divide_by")

    @cached_property
    def _signals(self) -> dict[str, Signal]:
        return {signal.name: signal for signal in self.result.signals}


class Comparison(NamedTuple):
    """One signal of several runs in one picture."""

    name: str
    title: str
    signal: str
    runs: tuple[str, ...]
    spectrum: bool = False  # amplitudes over frequency, not values over time
    more: bool = False  # beside the figures of the case
    against: str = ""  # the signal along the horizontal axis, in place of time
    ratio: bool = False  # a strength ratio: the smallest value governs, infinite without stress


def read_story(
    case_dir: Path,
    run: str,
    title: str,
    sha256: str | None = None,
    drawn: Collection[str] = (),
) -> Story:
    """Read summary and result of a run. Raises ResultError.

    Of more than MOST_SIGNALS signals only the first are kept, and those of figures.

    Parameters
    ----------
    sha256 : digest of result.vtkhdf if it is known
    drawn : signals of figures
    """
    summary = read_summary(case_dir / run / "summary.json")
    if summary["run"] != run:
        raise ResultError(
            f"{case_dir / run / 'summary.json'}: key run: expected {run!r}, "
            f"found {summary['run']!r}"
        )
    file = case_dir / run / "result.vtkhdf"
    result = read_result(file)
    count = len(result.signals)
    if count > MOST_SIGNALS:
        kept = [s for i, s in enumerate(result.signals) if i < MOST_SIGNALS or s.name in drawn]
        # Copies: a view would keep the values of all.
        signals = tuple(replace(s, values=s.values.copy()) for s in kept)
        result = replace(result, signals=signals)
    shown = repr((run, title, summary.get("completed"), summary.get("strength")))
    sha256 = sha256 or file_sha256(file)
    content = hashlib.sha256((shown + sha256).encode()).hexdigest()
    inputs, left_out = read_inputs(case_dir, run), count - len(result.signals)
    return Story(run, title, summary, result, content, inputs, sha256, left_out)


def comparisons(case: Mapping[str, Any], stories: list[Story]) -> list[Comparison]:
    """Return the pictures that the case requests, then one of each signal that these do not show.

    With the existing runs.
    """
    there = {story.name for story in stories}
    wanted = dict(case.get("figures") or {})
    drawn = {figure["signal"] for figure in wanted.values()}
    wanted |= {
        (s.name if s.name not in wanted else f"{s.name}-all"): {
            "title": s.description or s.name,
            "signal": s.name,
            "runs": [story.name for story in stories],
            "more": bool(drawn),
        }
        for s in stories[0].result.signals
        if s.name not in drawn
    }
    comparisons_shown = []
    for name, figure in wanted.items():
        runs = tuple(run for run in figure["runs"] if run in there)
        if runs:
            title, spectrum = figure.get("title") or name, bool(figure.get("spectrum"))
            more, against = bool(figure.get("more")), str(figure.get("against") or "")
            signal = figure["signal"]
            ratio = any(story.is_ratio(signal) for story in stories)
            comparisons_shown.append(
                Comparison(name, title, signal, runs, spectrum, more, against, ratio)
            )
    return comparisons_shown


def read_inputs(case_dir: Path, run: str) -> dict[str, object]:
    """Return the mechanism of a run as `check` wrote it; empty if its file is not there."""
    mechanism = kept_table(case_dir / "runs" / f"{run}.json").get("mechanism")
    return mechanism if isinstance(mechanism, dict) else {}
