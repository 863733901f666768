"""The course of a run: completion, growth of the motion, refused steps, stalls."""

from collections.abc import Iterator

import numpy as np

from ..dynamics.analysis.recovery import scales, speed_of_drives
from ..dynamics.elements.forces.contract import CoordinateForce
from ..dynamics.elements.forces.table import FORCES
from ..dynamics.model.model import state_size
from ..errors import few
from ..integrators.generic.advice import Stall
from ..integrators.table import INTEGRATORS, treatment_of
from ..math.arrays import Array, distinct
from ..math.catalogue import Code, Expression, Expressions
from ..mechanism.built_mechanism import BuiltMechanism
from ..results.codes import (
    CHATTERS,
    CODES,
    ENERGY_JUMP,
    GROWS,
    ORDER_TWO,
    REFUSED,
    RUN_FAILED,
    RUN_INTERRUPTED,
    SPIN,
    STALLED,
    VIBRATION_DAMPED,
    Finding,
)
from .finished_run import FinishedRun
from .tolerances import GROWTH_OF_A_TENTH

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


PARTS, LAST = 10, 5
DRIVEN = 10_001  # output times at which drives are looked at
# Kinds whose force the user writes as an expression or as code: a feedback may be among them.
ACTIVE = {
    kind
    for kind, force in FORCES.items()
    if isinstance(force, CoordinateForce)
    and any(isinstance(key, Expression | Expressions | Code) for key in force.keys)
}


def growth_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding if the kinetic energy has grown exponentially beyond its scale."""
    peaks = _peaks(run)
    if peaks is None or not np.all(peaks[-LAST:] > GROWTH_OF_A_TENTH * peaks[-LAST - 1 : -1]):
        return
    t, y0 = run.solution.t, run.solution.y[0]
    size = scales(run.model, y0, run.mechanism.solver.t_end)
    # A drive may be fast for a moment, as a spline at a jump: motion that is prescribed, not grown.
    driven = speed_of_drives(run.model, y0, t[run.some(DRIVEN)], size.length)
    scale = max(size.energy, float(run.model.mass.sum()) * driven**2)
    value = float(peaks[-1] / scale) if scale > 0.0 else np.inf
    if value <= GROWS.limit:
        return
    named = [name for name, force in run.mechanism.forces.items() if force.kind in ACTIVE]
    forces = f": {few(named)}" if named else ""
    times = float((peaks[-1] / peaks[-LAST - 1]) ** (1.0 / LAST))
    every = float(t[-1] - t[0]) / PARTS
    text = (
        f"the motion grows exponentially: by t = {t[-1]:.4g} s the kinetic energy is "
        f"{peaks[-1]:.2g} J, {value:.2g} times that of the mechanism at its speed, and grows "
        f"{times:.2g}-fold in {every:.2g} s. Look for a feedback that is unstable{forces}"
    )
    yield GROWS.finding(text, t=float(t[-1]), value=value)


def _peaks(run: FinishedRun) -> Array | None:
    """Largest kinetic energy in each tenth of the run, (PARTS,) [J]; None of too few times."""
    known = np.array(run.past.kinetic)
    if not len(known) or not np.isfinite(known).all():
        return None
    first, last = float(run.solution.t[0]), float(known[-1, 0])
    part = np.minimum(
        (PARTS * (known[:, 0] - first) / max(last - first, 1e-300)).astype(int), PARTS - 1
    )
    if distinct(part).size < PARTS:
        return None
    return np.array([known[part == i, 1].max() for i in range(PARTS)])


AXES = "xyz"


def stall_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the stalls of a run, with the energy that was damped until its end."""
    for stall in run.solution.stalls:
        damped = run.solution.damped_energy
        share = damped / run.past.energy_in_play
        lost = f"; they lost {damped:.2g} J, {share:.2g} of the energy in play"
        yield stall_finding(run.built, stall, lost)


def stall_finding(built: BuiltMechanism, stall: Stall, lost: str = "") -> Finding:
    """Return what to say of a stall; `lost`: what is known of the energy that was damped.

    Parameters
    ----------
    built : the built mechanism
    stall : time, mean step and motion of the stall
    lost : what is known of the energy that was damped
    """
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


INSTEAD = 'constraints = "ggl" with rtol >= 3e-8, or radau or rk8'
WORTH_A_WORD = 100  # attempts: a shorter run costs nothing
# Longest step that helps, in average steps. With 1.0 the average itself becomes shorter: four-bars
# cost 1.07 to 1.18 times as much then, with 1.1 to 1.5 0.98 to 1.09 (test_refusals.py).
LONGEST = 1.25


def accuracy_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding where steps of order 2 keep a share of rtol, or are down to rounding."""
    solver = run.mechanism.solver
    treatment = treatment_of(solver).name
    if solver.rtol < INTEGRATORS[solver.integrator].smallest_rtol(treatment):
        text = (
            f'{solver.integrator} with constraints = "{treatment}" does not keep rtol = '
            f"{solver.rtol:g}: the error of a run may be 10 to 1000 times as large. Take "
        )
        yield ORDER_TWO.finding(text + INSTEAD, value=solver.rtol)


def refusal_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield one finding for a run whose share of refused attempts is above the limit.

    None where nothing would help: refusals where impacts or ramps begin are how steps are found,
    and a law that chatters is named.
    """
    refusals = run.solution.refusals
    if any(finding.code == CHATTERS.name for finding in run.noticed):
        return
    if refusals is None or refusals.attempts < WORTH_A_WORD or refusals.share <= REFUSED.limit:
        return
    reasons = []
    if refusals.rough:
        reasons.append(f"{refusals.rough} by the estimate of the error")
    if refusals.newton:
        reasons.append(f"{refusals.newton} by a Newton iteration that did not converge")
    why = f" ({', '.join(reasons)})" if reasons else ""
    body, motion = named_motion(run.built, refusals.component)
    cause = f"; most often because of {motion}" if refusals.component >= 0 else ""
    helps = []
    # Of a run that has small steps in places, as after impacts, a shorter longest step is no help.
    # An iteration that does not converge takes its time, and fails in the longest steps.
    longest = LONGEST * refusals.step
    if refusals.newton > refusals.rough or run.sizes.steps_with(longest) < refusals.attempts:
        helps.append(f"max_step = {longest:.2g}, {LONGEST:g} times the average step")
        if body and refusals.rough >= refusals.newton:
            helps.append(
                "if this motion is a vibration of no interest, cutoff_frequency or damping of "
                "the body"
            )
    if refusals.newton > refusals.rough:
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
        f"{refusals.share:.0%} of {refusals.attempts} attempts at a step were refused{why}{cause}. "
        f"What helps: {'; or '.join(helps)}"
    )
    yield REFUSED.finding(text, body=body, value=refusals.share)
