"""summary.json: the main numbers of a run, and what they are worth in words."""

import json
from collections.abc import Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypedDict

import numpy as np

from ..math.arrays import Array
from ..math.rows import spans
from ..package.common.files import write_text
from ..package.common.plain_data import plain
from .codes import UNDER_WAY, Entry, Finding
from .run_result import ResultError, Signal


class Summary(TypedDict, total=False):
    """Content of summary.json (docs/runs.md); those of earlier versions may lack keys."""

    case: str
    run: str
    completed: bool
    status: str
    message: str
    t_end: float
    signals: Mapping[str, MutableMapping[str, Any]]  # unit and MEASURES, by signal
    checks: Mapping[str, Any]
    provenance: Mapping[str, Any]
    strength: Mapping[str, Any]  # by body
    damping: Sequence[Mapping[str, Any]]
    fatigue: Mapping[str, Any]
    cost: dict[str, Any]
    hints: list[str]
    warnings: list[Entry]  # of `Finding.entry`
    fidelity: Mapping[str, Any]
    error_bars: Mapping[str, Any]
    objective: Mapping[str, Any]
    inputs_sha256: str


# Single numbers of a signal over time, and its amplitude spectrum.

EVEN = 1e-6  # of the output step: times that differ less are equally spaced
WINDOWS = ("hann", "none")


class SquareIntegral:
    """Integral of the square of a signal over time, taken block by block (trapezoidal rule).

    Intervals with NaN or inf at an end are left out.
    """

    def __init__(self) -> None:
        self._integral, self._length = 0.0, 0.0
        self._t, self._square = np.zeros(0), np.zeros(0)  # the last sample of the block before

    def take(self, t: Array, values: Array) -> None:
        """Add a block: times (k,) [s] and values (k,)."""
        t = np.concatenate([self._t, t])
        with np.errstate(over="ignore"):
            square = np.concatenate([self._square, np.square(values)])
        step = np.diff(t)
        mean = 0.5 * (square[1:] + square[:-1])
        known = np.isfinite(mean)
        self._integral += float(mean[known] @ step[known])
        self._length += float(step[known].sum())
        self._t, self._square = t[-1:], square[-1:]

    def rms(self) -> float | None:
        """Return the root mean square over time; of a single sample its magnitude."""
        if self._length > 0.0:
            return float(np.sqrt(self._integral / self._length))
        known = self._square[np.isfinite(self._square)]
        return float(np.sqrt(known[-1])) if known.size else None


def spectrum(t: Array, values: Array, window: str = "hann") -> tuple[Array, Array]:
    """Return frequencies (m,) [Hz] and amplitudes (m,) of a signal, in the unit of the signal.

    The mean is subtracted. A sine whose frequency is one of those returned has its amplitude
    there; a last interval that is shorter than the others is left out.

    Parameters
    ----------
    t, values : (k,)
    window : "hann" (less leakage between frequencies) or "none"

    Raises
    ------
    ValueError
        Fewer than four times, times at different distances, a value that is not finite, or
        another window.
    """
    t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
    if window not in WINDOWS:
        raise ValueError(f"window = {window!r}: expected one of {', '.join(WINDOWS)}")
    if len(t) > 2 and t[-1] - t[-2] < (t[1] - t[0]) * (1.0 - EVEN):
        t, values = t[:-1], values[:-1]
    if len(t) < 4:
        raise ValueError(f"spectrum: expected four output times or more, found {len(t)}")
    step = np.diff(t)
    if np.ptp(step) > EVEN * step[0]:
        raise ValueError("spectrum: expected output times at equal distances")
    if not np.isfinite(values).all():
        raise ValueError("spectrum: expected finite values only")
    n = len(t)
    # periodic form: its samples follow each other without a double end
    weight = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n) if window == "hann" else np.ones(n)
    mean = float(weight @ values) / float(weight.sum())
    amplitude = np.abs(np.fft.rfft(weight * (values - mean))) / weight.sum()
    amplitude[1 : None if n % 2 else -1] *= 2.0  # both signs of the frequency
    frequency = np.asarray(np.fft.rfftfreq(n, float(np.mean(step))), dtype=float)
    return frequency, np.asarray(amplitude)


# Damping ratios in the mechanism beside those of the bodies by themselves, in words.

CHANGED = 2.0  # factor between both ratios from which the screen has a line


def damping_lines(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a line for each entry of `damping` in summary.json whose ratios differ much."""
    return [
        f"damping of {e['body']}: {_percent(e['damping_ratio'])} at {e['frequency_hz']:.3g} Hz in "
        f"the mechanism, {_percent(e['own_damping_ratio'])} at {e['own_frequency_hz']:.3g} Hz by "
        f"itself{_remedy(e)}"
        for e in entries
        if not 1.0 / CHANGED < e["damping_ratio"] / e["own_damping_ratio"] < CHANGED
    ]


def _remedy(entry: Mapping[str, Any]) -> str:
    """Return the value of the key that gives in the mechanism the ratio of the body by itself."""
    wanted = entry["own_damping_ratio"] ** 2 / entry["damping_ratio"]
    if wanted >= 1.0:
        return ""
    return f"; damping_ratio = {wanted:.2g} gives {_percent(entry['own_damping_ratio'])} there"


def _percent(ratio: float) -> str:
    return f"{100.0 * ratio:.2g} %"


# What the results of a run are worth, by its own findings: one judgement for screen and report.

Verdict = Literal["good", "doubt", "bad"]


def findings(summary: Summary) -> list[Finding]:
    """Return the findings of a summary, in its order."""
    return [Finding.of_entry(entry) for entry in summary.get("warnings", [])]


def verdict(summary: Summary) -> Verdict:
    """Return what a run is worth.

    "bad": it ended early, or a finding of level error calls its results invalid; "doubt": it has
    warnings; "good": neither.
    """
    levels = {finding.level for finding in findings(summary)}
    if not (summary.get("completed", False) or is_under_way(summary)) or "error" in levels:
        return "bad"
    return "doubt" if "warning" in levels else "good"


def is_under_way(summary: Summary) -> bool:
    """Return whether a summary is that of the part so far of a run that goes on."""
    return any(finding.code == UNDER_WAY.name for finding in findings(summary))


def invalid_words(summary: Summary) -> str:
    """Return from when on a completed run is invalid, and why; empty if it is not."""
    errors = [finding for finding in findings(summary) if finding.level == "error"]
    if not errors or not summary.get("completed", False):
        return ""
    first = min(errors, key=lambda finding: finding.t or 0.0)
    return f"invalid from t = {first.t or 0.0:.4g} s ({first.code})"


# summary.json: the main numbers of a run, with a stable layout.

MEASURES = ("final", "min", "t_min", "max", "t_max", "rms", "peak_to_peak")


def signal_summary(signal: Signal, t: Array) -> dict[str, object]:
    """Return unit, final value, both extremes with their times [s], and root mean square.

    NaN and inf are ignored; a signal without finite values
    gives None for all.
    """
    low = high = None  # value and time
    final, square = np.nan, SquareIntegral()
    for first, end in spans(len(signal.values), 1):
        values, times = signal.values[first:end], t[first:end]
        known = np.flatnonzero(np.isfinite(values))
        final = values[-1]
        square.take(times, values)
        if not len(known):
            continue
        least, most = known[np.argmin(values[known])], known[np.argmax(values[known])]
        if low is None or values[least] < low[0]:
            low = float(values[least]), float(times[least])
        if high is None or values[most] > high[0]:
            high = float(values[most]), float(times[most])
    if low is None or high is None:
        return {"unit": signal.unit} | dict.fromkeys(MEASURES)
    return {
        "unit": signal.unit,
        "final": float(final) if np.isfinite(final) else None,
        "min": low[0],
        "t_min": low[1],
        "max": high[0],
        "t_max": high[1],
        "rms": square.rms(),
        "peak_to_peak": high[0] - low[0],
    }


def write_summary(path: str | Path, summary: Summary) -> None:
    """Write a summary as standard JSON: NaN and inf become null."""
    path = Path(path)
    try:
        text = json.dumps(
            plain(summary, finite=True), indent=2, ensure_ascii=False, allow_nan=False
        )
    except TypeError as error:
        raise ResultError(
            f"{path}: the summary contains a value that is not JSON: {error}"
        ) from None
    write_text(path, text + "\n")


def read_summary(path: str | Path) -> Summary:
    """Read a summary. Raises ResultError if it is missing or not a JSON table."""
    path = Path(path)
    try:
        summary: Summary = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ResultError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        raise ResultError(f"{path}: not a summary of a run: {error}") from error
    if not isinstance(summary, dict) or "run" not in summary:
        raise ResultError(f"{path}: key run: expected the summary of a run, there is no such key")
    return summary
