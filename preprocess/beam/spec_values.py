"""Checks of the values of a body specification, and their error messages."""

from typing import Any

import numpy as np

from ...solver.errors import did_you_mean


class SpecError(ValueError):
    """A body specification that cannot be used; names key, value and expectation."""


def expected(key: str, value: Any, wish: str) -> str:
    """Message for a value that does not meet its expectation."""
    return f"{key}: expected {wish}, found {value!r}"


def known_keys(table: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    """Raise SpecError for the first unknown key, with the nearest known one."""
    for key in table:
        if key not in known:
            hint = did_you_mean(str(key), known)
            name = f"{where}.{key}" if where else str(key)
            raise SpecError(f"{name}: unknown key{hint} (known: {', '.join(known)})")


def number(
    value: Any,
    key: str,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    unit: str = "",
) -> float:
    """Return a finite number within its bounds; SpecError names the key otherwise."""
    bounds = [
        f"{word} {bound:g}"
        for word, bound in (("above", above), ("of at least", least), ("of at most", most))
        if bound is not None
    ]
    wish = " ".join(["a number", " and ".join(bounds), f"[{unit}]" if unit else ""]).strip()
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise SpecError(expected(key, value, wish))
    inside = (
        (above is None or value > above)
        and (least is None or value >= least)
        and (most is None or value <= most)
    )
    if not inside:
        raise SpecError(expected(key, value, wish))
    return float(value)


def count(value: Any, key: str) -> int:
    """Return a whole number of at least 1; SpecError names the key otherwise."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise SpecError(expected(key, value, "a whole number of at least 1"))
    return value


def one_of(value: Any, known: tuple[str, ...], key: str) -> str:
    """Return one of the known words; SpecError names the key and the nearest otherwise."""
    if value not in known:
        hint = did_you_mean(str(value), known)
        raise SpecError(expected(key, value, f"one of {', '.join(known)}") + hint)
    return str(value)
