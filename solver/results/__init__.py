"""Results of a run: result.vtkhdf with all histories, summary.json with the main numbers."""

from .reader import read_result
from .schema import BodyGeometry, ResultError, RunResult, Signal, energy_in_play, relative_balance
from .summary import read_summary, signal_summary, write_summary
from .writer import write_animation, write_result

__all__ = [
    "BodyGeometry",
    "ResultError",
    "RunResult",
    "Signal",
    "energy_in_play",
    "read_result",
    "read_summary",
    "relative_balance",
    "signal_summary",
    "write_animation",
    "write_result",
    "write_summary",
]
