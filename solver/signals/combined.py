"""Sensors of combined signals: differences and norms, also to the histories of another run."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..errors import InputError
from ..math.arrays import Array
from .sections import Look, Values

Measuring = Callable[[str], tuple[str, Values, Look | None]]  # by name: unit, values, look
# Of each other run: its times (n,) and its signals by name (n,).
Histories = Mapping[str, tuple[Array, Mapping[str, Array]]]


def combined(
    name: str, signal: Any, measuring: Measuring, histories: Histories
) -> tuple[str, Values, Look | None]:
    """Return unit, values and look of a difference or a norm.

    Raises
    ------
    InputError
        Signals of different units.
    """
    names = signal.of if signal.kind == "norm" else [signal.of]
    found = [measuring(part) for part in names]
    looks = [look for _, _, look in found if look is not None]
    units = [unit for unit, _, _ in found]
    terms = [values for _, values, _ in found]
    if signal.run is not None:
        there = names if signal.kind == "norm" else [signal.minus or signal.of]
        terms = [
            _minus(values, _history(histories, signal.run, other))
            for values, other in zip(terms, there, strict=True)
        ]
    elif signal.kind == "difference":
        unit, values, look = measuring(signal.minus)
        units.append(unit)
        looks += [look] if look is not None else []
        terms = [_minus(terms[0], values)]
    if len(set(units)) > 1:
        different = " and ".join(dict.fromkeys(units))
        raise InputError(f"signals.{name}: expected signals of one unit, found {different}")

    def look_all(recording: Recording) -> None:
        for look in looks:
            look(recording)

    total = _norm(terms) if signal.kind == "norm" else terms[0]
    return units[0], total, look_all if looks else None


def _minus(one: Values, two: Values) -> Values:
    return lambda recording: one(recording) - two(recording)


def _norm(terms: list[Values]) -> Values:
    def norm(recording: Recording) -> Array:
        return np.asarray(np.sqrt(sum(np.square(values(recording)) for values in terms)))

    return norm


def _history(histories: Histories, run: str, name: str) -> Values:
    """Return what gives a signal of another run at the times of a recording; NaN after its end."""
    t, signals = histories[run]

    def values(recording: Recording) -> Array:
        return np.interp(recording.t, t, signals[name], right=np.nan)

    return values
