"""Checks of the provenance of a package: the parts of it that the solver reads."""

from math import isfinite
from typing import Any

from ..common.array_checks import Reporter


def check_provenance(found: Any, error: Reporter) -> None:
    """Report entries of `provenance` that are not of the documented form."""
    warnings, seconds = found.get("warnings", []), found.get("seconds", {})
    if not isinstance(warnings, list) or not all(map(_is_warning, warnings)):
        error("provenance", "warnings: expected a list of tables with the texts code and message")
    numbers = seconds.values() if isinstance(seconds, dict) else [None]
    if not all(_is_number(number) for number in numbers):
        error("provenance", "seconds: expected a table of numbers")


def _is_warning(item: Any) -> bool:
    return isinstance(item, dict) and all(
        isinstance(item.get(key), str) for key in ("code", "message")
    )


def _is_number(number: Any) -> bool:
    return isinstance(number, int | float) and not isinstance(number, bool) and isfinite(number)
