"""Fatigue of a stress history: rainflow cycles, S-N line, Miner's sum.

Cycles are counted as in ASTM E1049-85, section 5.4.4, by the package `rainflow`. A cycle of the
amplitude a and the mean m counts as one of a / (1 - m / ultimate) without mean (Goodman), a mean in
compression as none. Miner's sum adds count / N over all cycles; failure is expected at 1.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..math.arrays import Array, distinct

CLASSES = 16  # of ranges, in the summary


class Cycles(NamedTuple):
    """Cycles and half cycles of a history, (c,) each."""

    ranges: Array  # peak to valley, in the unit of the history
    means: Array
    counts: Array  # 1 or 0.5


class StressLife(NamedTuple):
    """An S-N line: straight between its points, and beyond them, over logarithms of both."""

    amplitude: Array  # (n,) descending [Pa]
    cycles: Array  # (n,) to failure, ascending
    ultimate: float = np.inf  # of Goodman's line [Pa]
    limit: float = 0.0  # amplitude up to which cycles do no damage [Pa]

    def life(self, amplitude: Array, mean: Array) -> Array:
        """Cycles to failure (c,), at least 1, under an amplitude and a mean (c,) [Pa]."""
        share = np.clip(mean / self.ultimate, 0.0, 1.0)
        with np.errstate(divide="ignore"):
            x = np.log(np.where(share < 1.0, amplitude / np.maximum(1.0 - share, 1e-300), np.inf))
        S, N = np.log(self.amplitude), np.log(self.cycles)
        # The segment of each amplitude; the first and the last one go on.
        k = np.clip(np.searchsorted(-S, -x, side="right") - 1, 0, len(S) - 2)
        with np.errstate(over="ignore", invalid="ignore"):
            life = np.exp(N[k] + (x - S[k]) * (N[k + 1] - N[k]) / (S[k + 1] - S[k]))
        return np.where(x <= np.log(max(self.limit, 1e-300)), np.inf, np.maximum(life, 1.0))

    def damage(self, cycles: Cycles) -> Array:
        """Share of Miner's sum of each cycle, (c,)."""
        return np.asarray(cycles.counts / self.life(0.5 * cycles.ranges, cycles.means))


class Turning:
    """Turning points of a history that comes in blocks."""

    def __init__(self) -> None:
        self._found: list[Array] = []
        self._tail = np.zeros(0)  # the last two values that differ

    def take(self, values: Array) -> None:
        """Take values (k,) after the last ones."""
        first = not self._tail.size
        whole = np.concatenate([self._tail, values])
        whole = whole[np.append(True, np.diff(whole) != 0.0)]
        rise = np.sign(np.diff(whole))
        if first:
            self._found.append(whole[:1])
        self._found.append(whole[1:-1][rise[1:] * rise[:-1] < 0.0])
        self._tail = whole[-2:]

    def points(self) -> Array:
        """First value, turning points and last value so far, (n,)."""
        return np.concatenate([*self._found, self._tail[1:]])


def check_rainflow(key: str) -> None:
    """Raise InputError if cycles cannot be counted; `key` asked for it."""
    try:
        import rainflow  # noqa: F401 - optional
    except ImportError:
        raise InputError(
            f"{key}: cycles are counted by the package rainflow: pip install rainflow"
        ) from None


def rainflow_cycles(points: Iterable[float]) -> Cycles:
    """Count the cycles of a history, or of its turning points."""
    from rainflow import extract_cycles

    cycles = np.array([cycle[:3] for cycle in extract_cycles(points)]).reshape(-1, 3)
    return Cycles(*cycles.T)


def fatigue_summary(cycles: Cycles, line: StressLife) -> dict[str, object]:
    """The entry of a stress signal in summary.json: Miner's sum and classes of ranges."""
    damage = line.damage(cycles)
    total, top = float(damage.sum()), float(cycles.ranges.max(initial=0.0))
    edges = top * np.arange(1, CLASSES + 1) / CLASSES
    which = np.minimum(np.searchsorted(edges, cycles.ranges), CLASSES - 1)
    classes = [
        {
            "range": float(edges[k]),
            "cycles": float(cycles.counts[which == k].sum()),
            "damage": float(damage[which == k].sum()),
        }
        for k in distinct(which)
    ]
    return {
        "damage": total,
        "repetitions": 1.0 / total if total > 0.0 else None,
        "cycles": float(cycles.counts.sum()),
        "largest_range": top,
        "classes": classes,
    }
