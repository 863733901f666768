"""summary.json: the main numbers of a run, with a stable layout."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..package.common.temporary import temporary_sibling
from .schema import ResultError, Signal


def signal_summary(signal: Signal, t: Array) -> dict[str, Any]:
    """Return unit, final value and both extremes of a signal with their times [s].

    NaN and inf are ignored; a signal without finite values
    gives None for all.
    """
    known = np.flatnonzero(np.isfinite(signal.values))
    if not len(known):
        return {"unit": signal.unit} | dict.fromkeys(("final", "min", "t_min", "max", "t_max"))
    low = known[np.argmin(signal.values[known])]
    high = known[np.argmax(signal.values[known])]
    return {
        "unit": signal.unit,
        "final": float(signal.values[-1]) if known[-1] == len(signal.values) - 1 else None,
        "min": float(signal.values[low]),
        "t_min": float(t[low]),
        "max": float(signal.values[high]),
        "t_max": float(t[high]),
    }


def write_summary(path: str | Path, summary: dict[str, Any]) -> None:
    """Write a summary as standard JSON: NaN and inf become null."""
    path = Path(path)
    try:
        text = json.dumps(_plain(summary), indent=2, ensure_ascii=False, allow_nan=False)
    except TypeError as error:
        raise ResultError(
            f"{path}: the summary contains a value that is not JSON: {error}"
        ) from None
    with temporary_sibling(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def read_summary(path: str | Path) -> dict[str, Any]:
    """Read a summary. Raises ResultError if it is missing or not a JSON table."""
    path = Path(path)
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ResultError(f"{path}: not a summary of a run: {error}") from error
    if not isinstance(summary, dict) or "run" not in summary:
        raise ResultError(f"{path}: key run: expected the summary of a run, there is no such key")
    return summary


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
