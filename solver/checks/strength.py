"""Strength of the plies of every body whose package has strengths."""

from collections.abc import Iterator

from ..results.codes.motion import PLY_FAILURE
from ..results.finding import Finding
from ..strength.beam_bodies import beam_search
from ..strength.found import BodyStrength, failure_text
from ..strength.shell_bodies import shell_search
from .finished import FinishedRun


def body_strengths(run: FinishedRun) -> dict[str, BodyStrength]:
    """Return the strength of every body whose package can tell, at the times of `look.strength`."""
    found = {}
    for i, name in enumerate(run.built.body_names):
        package = run.packages.get(name)
        if package is None:
            continue
        search = beam_search(package) or shell_search(package)
        if search is None:
            continue
        for t, q in run.modes(i, run.look.strength):
            search.take(t, q)
        strength = search.found()
        if strength is not None:
            found[name] = strength
    return found


def strength_findings(strengths: dict[str, BodyStrength]) -> Iterator[Finding]:
    """Yield bodies of which a ply fails."""
    for name, strength in strengths.items():
        worst = strength.governing
        if worst.ratio < PLY_FAILURE.limit:
            text = failure_text(name, worst)
            yield PLY_FAILURE.finding(text, body=name, t=worst.time, value=worst.ratio)
