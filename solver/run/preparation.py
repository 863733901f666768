"""A mechanism ready to be integrated: model, consistent start, monitors, sensors."""

from collections.abc import Callable, Container
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..checks.findings import Finding, finding
from ..dynamics.constraints.treatment import Treatment, treated, treatment_of
from ..dynamics.model import Model
from ..integrators.generic import Integrator, Solution, StopRequest
from ..math.arrays import Array
from ..mechanism import BuiltMechanism, build
from ..mechanism.equilibrium import starting_state
from ..mechanism.initial import redundancy
from ..monitors.energy import JUMP_CODE
from ..monitors.singularity import SINGULAR_CODE, SingularityMonitor
from ..monitors.spin import SPIN_CODE, SpinMonitor
from ..package import ModalPackage
from ..signals import Sensor, sensors

Watch = Callable[[Integrator], StopRequest | None]

SINGULAR_START = (
    "the mechanism starts in a singular position, where it could move in more directions than "
    "elsewhere: give velocities that say which"
)


@dataclass(frozen=True)
class Prepared:
    """What a run has before its first step, and what judges it afterwards."""

    built: BuiltMechanism
    treatment: Treatment
    y0: Array  # (n,)
    measured: dict[str, Sensor]
    spin: SpinMonitor
    passage: SingularityMonitor
    notes: list[Finding]  # what a user should know of the start
    refused: Solution | None  # in place of a run that should not begin

    @property
    def model(self) -> Model:
        """The model, made ready for its treatment of constraints."""
        return self.built.model

    def watch(self, integrator: Integrator) -> StopRequest | None:
        """Show the step just taken to all monitors; the earliest of their requests."""
        found = [monitor(integrator) for monitor in (self.spin, self.passage)]
        requests = [request for request in found if request is not None]
        return min(requests, key=lambda request: request.t_stop, default=None)

    def explained(self, solution: Solution) -> Solution:
        """Return the solution; of a run that failed in a singular position, with words on that."""
        if solution.status != "failed":
            return solution
        cause = self.passage.explain(float(solution.t[-1]), solution.y[-1])
        if not cause:
            return solution
        message = f"{cause} ({solution.message})"
        return replace(solution, message=message, code=SINGULAR_CODE)

    def noticed(self) -> list[Finding]:
        """Return what start and run met: singular positions and jumps of energy."""
        return [*self.notes, *_of_passage(self.passage)]


def prepare(
    mechanism: dict[str, Any],
    packages: dict[str, ModalPackage],
    signals: Container[str] | None = None,
) -> Prepared:
    """Build a checked mechanism (inputs/case/schema.py), close its joints, look at it.

    `signals` are those that will be asked for; None: all.

    Raises
    ------
    InputError
        A mechanism that cannot be assembled, contradictory constraints.
    """
    solver = mechanism["solver"]
    treatment = treatment_of(solver)
    built = build(mechanism, packages)
    y0 = starting_state(
        built.model, built.start, solver["start"], built.joint_names, built.body_names
    )
    found = redundancy(built.model, y0, built.joint_names)
    notes = [finding("redundant-constraints", found.message)] if found.count else []
    if found.singular_start:
        notes.append(finding("singular-start", SINGULAR_START))
    built = replace(built, model=treated(built.model, treatment)._replace(redundant=found.count))
    wanted = {
        name: table
        for name, table in mechanism["signals"].items()
        if signals is None or name in signals
    }
    spin = SpinMonitor(built.model, built.body_names, stop=solver["on_invalid"] == "stop")
    passage = SingularityMonitor(
        built.model,
        built.joint_names,
        treatment.name,
        stop=solver.get("on_singular", "stop") == "stop",
    )
    words = spin.at_start(0.0, y0)
    passage.at_start(0.0, y0)
    refused = None
    if words is not None:
        refused = Solution(np.zeros(1), y0[None, :], "stopped", words, SPIN_CODE)
    return Prepared(
        built=built,
        treatment=treatment,
        y0=y0,
        measured=sensors(built, wanted),
        spin=spin,
        passage=passage,
        notes=notes,
        refused=refused,
    )


def _of_passage(passage: SingularityMonitor) -> list[Finding]:
    """What the run met on its way: singular positions and jumps of energy."""
    notes = [finding(code, message) for code, message in passage.warnings]
    if passage.passes and not passage.warnings:
        times = ", ".join(f"{t:.4g}" for t in passage.passes[:5])
        more = " ..." if len(passage.passes) > 5 else ""
        notes.append(
            finding(
                "singular-passed",
                f"{len(passage.passes)} singular positions on the way, at t = {times}{more} s, "
                "where the mechanism could leave in more than one direction; velocity and energy "
                "were continued",
            )
        )
    if passage.energy.message:
        notes.append(finding(JUMP_CODE, passage.energy.message))
    return notes
