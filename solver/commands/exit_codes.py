"""Exit codes of the commands."""

from collections.abc import Iterable

from ..interrupts import INTERRUPTED
from .defect import DEFECT

INPUT = 2  # something is wrong with an input
INCOMPLETE = 3  # a run ended early, or its results are not valid to the end; what there is, is kept


def worst(codes: Iterable[int]) -> int:
    """Return the exit code of several parts of a command."""
    found = set(codes)
    return next((code for code in (INTERRUPTED, DEFECT, INPUT, INCOMPLETE) if code in found), 0)
