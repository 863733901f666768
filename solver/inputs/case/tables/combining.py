"""What combined signals read; also of run files, without the models of the schema."""

from collections.abc import Collection, Mapping
from typing import Any

KINDS = ("difference", "norm")


def parts(signal: Any) -> list[str]:
    """Return the signals of its own run that a combined signal reads; none of another signal."""
    if signal.kind == "norm":
        return list(signal.of)
    if signal.kind != "difference":
        return []
    return [signal.of, *([signal.minus] if signal.minus and signal.run is None else [])]


def elsewhere(signal: Any) -> list[str]:
    """Return the signals of its `run` that a combined signal reads."""
    if signal.kind not in KINDS or signal.run is None:
        return []
    return list(signal.of) if signal.kind == "norm" else [signal.minus or signal.of]


def needed(signals: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the other runs that signals read, with the names of what is read there."""
    found: dict[str, dict[str, None]] = {}
    for signal in signals.values():
        for name in elsewhere(signal):
            found.setdefault(signal.run, {})[name] = None
    return {run: list(names) for run, names in found.items()}


def with_parts(names: Collection[str], signals: Mapping[str, Any]) -> dict[str, Any]:
    """Return signals by name with all those that they read in the same run."""
    found: dict[str, Any] = {}
    left = list(names)
    while left:
        name = left.pop()
        if name not in found and name in signals:
            found[name] = signals[name]
            left += parts(signals[name])
    return found
