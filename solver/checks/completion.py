"""Completion of a run: why it ended early, and what preparation and monitors noticed."""

from collections.abc import Iterator

from ..results.codes import CODES
from ..results.codes.course import RUN_FAILED, RUN_INTERRUPTED
from ..results.codes.motion import ENERGY_JUMP, SPIN
from ..results.finding import Finding
from .finished import FinishedRun

_ENDS = {"failed": RUN_FAILED, "interrupted": RUN_INTERRUPTED}


def completion_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield invalid bodies first, then an early end, then what else was noticed."""
    yield from (finding for finding in run.noticed if finding.code == SPIN.name)
    known = {finding.code for finding in run.noticed}
    solution = run.solution
    if solution.status != "finished" and solution.code not in known:
        code = CODES[solution.code] if solution.code else _ENDS[solution.status]
        yield code.finding(solution.message, t=float(solution.t[-1]))
    for finding in run.noticed:
        # Nothing moves in a locked mechanism: there is no energy to balance.
        if finding.code == ENERGY_JUMP.name and run.degrees_of_freedom == 0:
            continue
        if finding.code != SPIN.name:
            yield finding
