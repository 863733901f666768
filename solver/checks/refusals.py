"""Runs in which many attempts at a step were refused: why, by which motion, and what helps."""

from collections.abc import Iterator

from ..dynamics.forces.table import FORCES
from ..errors import few
from ..results.codes.course import REFUSED
from ..results.finding import Finding
from .finished import FinishedRun
from .stalls import named_motion

WORTH_A_WORD = 100  # attempts: a shorter run costs nothing
# Longest step that helps, in average steps. With 1.0 the average itself becomes shorter: four-bars
# cost 1.07 to 1.18 times as much then, with 1.1 to 1.5 0.98 to 1.09 (test_refusals.py).
LONGEST = 1.25


def refusal_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield one finding for a run whose share of refused attempts is above the limit.

    None where nothing would help: refusals where impacts or ramps begin are how steps are found.
    """
    found = run.solution.refusals
    if found is None or found.attempts < WORTH_A_WORD or found.share <= REFUSED.limit:
        return
    reasons = []
    if found.rough:
        reasons.append(f"{found.rough} by the estimate of the error")
    if found.newton:
        reasons.append(f"{found.newton} by a Newton iteration that did not converge")
    why = f" ({', '.join(reasons)})" if reasons else ""
    body, motion = named_motion(run.built, found.component)
    cause = f"; most often because of {motion}" if found.component >= 0 else ""
    helps = []
    # Of a run that has small steps in places, as after impacts, a shorter longest step is no help.
    # An iteration that does not converge takes its time, and fails in the longest steps.
    longest = LONGEST * found.step
    if found.newton > found.rough or run.sizes.steps_with(longest) < found.attempts:
        helps.append(f"max_step = {longest:.2g}, {LONGEST:g} times the average step")
        if body and found.rough >= found.newton:
            helps.append(
                "if this motion is a vibration of no interest, cutoff_frequency or damping of "
                "the body"
            )
    if found.newton > found.rough:
        advice = {
            name: FORCES[force.kind].steep
            for name, force in run.mechanism.forces.items()
            if FORCES[force.kind].steep
        }
        for change in dict.fromkeys(advice.values()):
            names = few([f"forces.{name}" for name, of in advice.items() if of == change])
            helps.insert(0, f"for {names} {change}")
    if not helps:
        return
    text = (
        f"{found.share:.0%} of {found.attempts} attempts at a step were refused{why}{cause}. "
        f"What helps: {'; or '.join(helps)}"
    )
    yield REFUSED.finding(text, body=body, value=found.share)
