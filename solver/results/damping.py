"""Damping ratios in the mechanism beside those of the bodies by themselves, in words."""

from collections.abc import Mapping, Sequence
from typing import Any

CHANGED = 2.0  # factor between both ratios from which the screen has a line


def damping_lines(entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a line for each entry of `damping` in summary.json whose ratios differ much."""
    return [
        f"damping of {e['body']}: {_percent(e['damping_ratio'])} at {e['frequency_hz']:.3g} Hz in "
        f"the mechanism, {_percent(e['own_damping_ratio'])} at {e['own_frequency_hz']:.3g} Hz by "
        "itself"
        for e in entries
        if not 1.0 / CHANGED < e["damping_ratio"] / e["own_damping_ratio"] < CHANGED
    ]


def _percent(ratio: float) -> str:
    return f"{100.0 * ratio:.2g} %"
