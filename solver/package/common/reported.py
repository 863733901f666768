"""Warnings of an analysis in a results file."""

from collections.abc import Mapping, Sequence
from typing import Any

from .dataset import DatasetSpec, T, spec

WARNINGS_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("warnings/codes", "w", T, "-", "-", "a word for each warning of the analysis"),
    spec("warnings/messages", "w", T, "-", "-", "the warning for people"),
)
WARNINGS_SIZED_BY = {"w": "warnings/codes"}


def warning_values(warnings: Sequence[Mapping[str, str]]) -> dict[str, Any]:
    """Return the value of every dataset of WARNINGS_LAYOUT by path."""
    return {
        "warnings/codes": [warning["code"] for warning in warnings],
        "warnings/messages": [warning["message"] for warning in warnings],
    }


def warnings_from(data: Mapping[str, Any]) -> tuple[dict[str, str], ...]:
    """Put the values of WARNINGS_LAYOUT together: {"code", "message"} of each."""
    reported = zip(data["warnings/codes"], data["warnings/messages"], strict=True)
    return tuple({"code": code, "message": message} for code, message in reported)
