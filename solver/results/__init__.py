"""Results of a run: result.vtkhdf with all histories, summary.json with the main numbers."""

from .file import read_result, write_animation, write_result
from .run_result import (
    BodyGeometry,
    Derivative,
    ResultError,
    RunResult,
    Signal,
    energy_in_play,
    relative_balance,
)
from .summary import Summary, read_summary, signal_summary, write_summary
