"""Damping ratios in the mechanism beside those of the bodies by themselves, in words."""

from collections.abc import Mapping, Sequence
from typing import Any

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
