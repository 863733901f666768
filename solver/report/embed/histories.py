"""Histories of a run for the plots: signals, energies, error of their balance, violations."""

from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ...results import RunResult
from ..balance import UNITS, WORDS
from .blob import Blob

NUMBERS = 350_000  # of all histories of a page; longer ones keep the extremes of intervals
FEWEST = 500  # rows of a run at least


def histories(blob: Blob, result: RunResult, share: int) -> dict[str, Any]:
    """Add the histories of a run; return what the page needs to plot them.

    share : numbers that this run may take
    """
    groups = {
        "signals": [(s.name, s.unit, s.description or s.name, s.values) for s in result.signals],
        "energies": [(n, "J", words, _from_start(n, result)) for n, words in WORDS.items()],
        "balance": [("balance", "-", "error of the energy balance", result.relative_balance)],
        "violations": [(n, UNITS.get(n, "-"), n, v) for n, v in result.violations.items()],
    }
    every = [np.asarray(each[3]) for group in groups.values() for each in group]
    rows = chosen_rows(every, len(result.t), max(share // (len(every) + 2), FEWEST))
    found: dict[str, Any] = {
        "t": blob.add(np.asarray(result.t)[rows], "<f8"),
        "complete": len(rows) == len(result.t),
        "steps": len(result.t),
    }
    for name, group in groups.items():
        found[name] = [
            {"name": n, "unit": unit, "text": text, "values": blob.add(np.asarray(values)[rows])}
            for n, unit, text, values in group
        ]
    return found


def chosen_rows(series: list[Array], k: int, most: int) -> IntArray:
    """Return at most about `most` of k rows: all, or the extremes of every series in intervals.

    No maximum or minimum of an interval is lost, in contrast to every n-th row.
    """
    if k <= most or not series:
        return np.arange(k)
    size = -(-k * 2 * len(series) // most)  # rows of an interval
    starts = np.arange(0, k, size)
    kept = [np.array([0, k - 1])]
    for values in series:
        padded = np.full(len(starts) * size, np.nan)
        padded[:k] = values
        blocks = np.where(np.isfinite(padded), padded, np.nan).reshape(len(starts), size)
        usable = np.flatnonzero(np.isfinite(blocks).any(axis=1))
        for extreme in (np.nanargmin, np.nanargmax):
            kept.append(starts[usable] + extreme(blocks[usable], axis=1))
    return np.unique(np.concatenate(kept))


def _from_start(name: str, result: RunResult) -> Array:
    values = np.asarray(result.energies[name])
    return values - values[0] if name == "potential" else values
