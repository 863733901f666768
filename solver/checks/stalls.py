"""Runs that came to a stall: which motion kept the steps short, and what was damped to go on."""

from collections.abc import Iterator

import numpy as np

from ..dynamics.model import state_size
from ..integrators.generic.pace import Stall
from ..mechanism import BuiltMechanism
from ..results.codes.course import STALLED, VIBRATION_DAMPED
from ..results.finding import Finding
from .finished import FinishedRun

AXES = "xyz"


def stall_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the stalls of a run, with the energy that was damped until its end."""
    for stall in run.solution.stalls:
        damped = run.solution.damped_energy
        share = damped / run.past.energy_in_play
        lost = f"; they lost {damped:.2g} J, {share:.2g} of the energy in play"
        yield stall_finding(run.built, stall, lost)


def stall_finding(built: BuiltMechanism, stall: Stall, lost: str = "") -> Finding:
    """Return what to say of a stall; `lost`: what is known of the energy that was damped."""
    body, motion = named_motion(built, stall.component)
    rate = f" (about {stall.rate:.2g} rad/s)" if stall.rate > 0.0 else ""
    why = (
        f"the steps before t = {stall.t:.6g} s averaged {stall.step:.2g} s, {stall.refused:.0%} of "
        f"the attempts were refused; the fastest motion is {motion}{rate}"
    )
    if stall.cutoff > 0.0:
        text = (
            f"{why}. From then on vibrations above {stall.cutoff:.4g} rad/s are damped, not "
            f"resolved{lost}. If they matter, set cutoff_frequency = 0; if not, set "
            "cutoff_frequency for the whole run, or give them damping"
        )
        return VIBRATION_DAMPED.finding(text, body=body, t=stall.t, value=stall.cutoff)
    text = f"{why}. What helps: {stall.remedy}"
    return STALLED.finding(text, body=body, t=stall.t, value=stall.step)


def named_motion(built: BuiltMechanism, component: int) -> tuple[str, str]:
    """Return body and description of a component of the state; "" for one of no body."""
    model = built.model
    velocity, n = component >= model.n_pos, state_size(model)
    if component == n - 1:
        return "", "the work of drives, loads and dampers"
    if component >= model.n_pos + model.n_vel:
        return "", "a state of a controller or of friction"
    if component < 0:
        return "", "unknown"
    starts = np.asarray(model.vel_start) + model.n_pos if velocity else np.asarray(model.pos_start)
    i = int(np.searchsorted(starts, component, side="right")) - 1
    if i >= len(built.body_names):
        return "", "that of a virtual body"
    name, frame = built.body_names[i], 6 if velocity else 7
    k = component - int(starts[i])
    if k < 3:
        return name, f"that of {name} along {AXES[k]}"
    if k < frame:
        return name, f"a rotation of {name}"
    package = built.packages.get(name)
    kind = f", {package.mode_kinds[k - frame].replace('_', ' ')}" if package is not None else ""
    return name, f"mode {k - frame + 1} of {name}{kind}"
