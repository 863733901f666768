"""summary.json: the main numbers of a run, with a stable layout."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..math.rows import spans
from ..package.common.temporary import write_text
from .measures import SquareIntegral
from .schema import ResultError, Signal

MEASURES = ("final", "min", "t_min", "max", "t_max", "rms", "peak_to_peak")


def signal_summary(signal: Signal, t: Array) -> dict[str, Any]:
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


def write_summary(path: str | Path, summary: dict[str, Any]) -> None:
    """Write a summary as standard JSON: NaN and inf become null."""
    path = Path(path)
    try:
        text = json.dumps(plain(summary), indent=2, ensure_ascii=False, allow_nan=False)
    except TypeError as error:
        raise ResultError(
            f"{path}: the summary contains a value that is not JSON: {error}"
        ) from None
    write_text(path, text + "\n")


def read_summary(path: str | Path) -> dict[str, Any]:
    """Read a summary. Raises ResultError if it is missing or not a JSON table."""
    path = Path(path)
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ResultError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        raise ResultError(f"{path}: not a summary of a run: {error}") from error
    if not isinstance(summary, dict) or "run" not in summary:
        raise ResultError(f"{path}: key run: expected the summary of a run, there is no such key")
    return summary


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: arrays as lists, NaN and infinity as null."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
