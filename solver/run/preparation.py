"""A mechanism ready to be integrated: model, consistent start, monitors, sensors."""

from collections.abc import Callable, Container
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..checks.finished import FinishedRun, Look
from ..checks.monitors.buckling import BucklingMonitor
from ..checks.monitors.singularity import SingularityMonitor
from ..checks.monitors.spin import SpinMonitor
from ..checks.monitors.step_sizes import StepSizes
from ..checks.monitors.together import Monitors
from ..dynamics.analysis.scales import scales
from ..dynamics.elements.constraints.treatment import Treatment, treated
from ..dynamics.model.model import Model
from ..inputs.case.expressions import is_smooth
from ..integrators.choice import treatment_of
from ..integrators.generic.drive import Solution
from ..math.arrays import Array
from ..mechanism import BuiltMechanism, build
from ..mechanism.building.modes import used_packages
from ..mechanism.building.python_functions import Called, python_functions, require_permission
from ..mechanism.consistent.initial import redundancy
from ..mechanism.starting.moved import moved_findings
from ..mechanism.starting.relative_equilibrium import given_spin
from ..mechanism.starting.start import starting_state
from ..package import ModalPackage
from ..results.codes import SINGULAR, Finding
from ..signals import Histories, Sensor, Turns, sensors

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism


NOTHING = 1e-13  # of the energy of a mechanism at its speed: round-off
# The energy of a motion is known to a thousandth, the limit of the balance, where its speed is a
# thousand tolerances. Slower motion is noise of the steps, but above a hundredth of the scale.
NOISE, MOST_NOISE = 1e3, 1e-2


@dataclass(frozen=True)
class Prepared:
    """What a run has before its first step, and what judges it afterwards."""

    mechanism: "Mechanism"
    built: BuiltMechanism
    treatment: Treatment
    y0: Array  # (n,)
    measured: dict[str, Sensor]
    spin: SpinMonitor
    passage: SingularityMonitor
    buckling: BucklingMonitor | None  # None: no body has second-order data
    notes: list[Finding]  # what a user should know of the start
    independent: bool  # whether no constraint depends on others at the start
    refused: Solution | None  # in place of a run that should not begin
    turns: Turns  # of the angles among the signals
    functions: tuple[Called, ...] = ()  # of the user, which controllers call
    sizes: StepSizes = field(default_factory=StepSizes)

    @property
    def model(self) -> Model:
        """The model, made ready for its treatment of constraints."""
        return self.built.model

    @property
    def watch(self) -> Monitors:
        """All monitors."""
        return Monitors(self.spin, self.passage, self.buckling, self.turns, self.sizes)

    def explained(self, solution: Solution) -> Solution:
        """Return the solution, with an explanation if it failed at a singular position."""
        if solution.status != "failed":
            return solution
        cause = self.passage.explain(float(solution.t[-1]), solution.y[-1])
        if not cause:
            return solution
        message = f"{cause} ({solution.message})"
        return replace(solution, message=message, code=SINGULAR.name)

    def finished(self, solution: Solution, order: int, look: Look) -> FinishedRun:
        """Return the run as the checks see it; `order` is that of the integrator."""
        passage, t_end = self.passage, solution.t[-1]
        # Two monitors may ask for a stop in the same step; what is beyond the earlier one is cut.
        found = [*self.spin.findings, *passage.findings]
        if self.buckling is not None:
            found += self.buckling.findings
        met = [f for f in found if f.t is None or f.t <= t_end]
        jumps = passage.energy.findings(sudden=not is_smooth(self.mechanism))
        noticed = (*met, *self.notes, *passage.passed(), *jumps)
        return FinishedRun(
            mechanism=self.mechanism,
            built=self.built,
            treatment=self.treatment,
            solution=solution,
            order=order,
            noticed=noticed,
            look=look,
            independent=self.independent,
            in_play=passage.energy.in_play,
            sizes=self.sizes,
        )


def prepare(
    mechanism: "Mechanism",
    packages: dict[str, ModalPackage],
    signals: Container[str] | None = None,
    *,
    allow_python: bool = False,
    adjust: Callable[[Model], None] | None = None,
    histories: Histories | None = None,
) -> Prepared:
    """Build a checked mechanism (inputs/case/tables/schema.py), close its joints, look at it.

    `signals` are those that will be asked for; None: all. `allow_python`: functions of the user
    may run. `adjust` may write into the arrays of the model before its joints are closed.
    `histories` of other runs as in `sensors`.

    Raises
    ------
    InputError
        A mechanism that cannot be assembled, contradictory constraints.
    """
    if not allow_python:
        require_permission(mechanism)
    functions = python_functions(mechanism)
    solver = mechanism.solver
    treatment = treatment_of(solver)
    built = build(mechanism, used_packages(mechanism, packages))
    if adjust is not None:
        adjust(built.model)
    names = built.joint_names, built.body_names
    spin = given_spin(solver)
    y0 = starting_state(built.model, built.start, solver.start, *names, spin, built.light)
    if not np.isfinite(y0).all():
        raise FloatingPointError("the starting state is not finite")
    moved = moved_findings(mechanism, built.model, built.start, y0, built.body_names)
    found = redundancy(built.model, y0, built.joint_names, t_end=solver.t_end)
    built = replace(built, model=treated(built.model, treatment)._replace(redundant=found.count))
    spins = SpinMonitor(built.model, built.body_names, stop=solver.on_invalid == "stop")
    passage = SingularityMonitor(
        built.model,
        built.joint_names,
        treatment.name,
        stop=solver.on_singular == "stop",
    )
    least = max(NOTHING, min((NOISE * solver.rtol) ** 2, MOST_NOISE))
    passage.energy.in_play = least * scales(built.model, y0, solver.t_end).energy
    invalid = spins.at_start(0.0, y0)
    passage.at_start(0.0, y0)
    refused = None
    if invalid is not None:
        refused = Solution(np.zeros(1), y0[None, :], "stopped", invalid.text, invalid.code)
    turns = Turns(built.model)
    return Prepared(
        mechanism=mechanism,
        built=built,
        treatment=treatment,
        y0=y0,
        measured=sensors(
            built,
            mechanism.signals,
            mechanism.materials,
            wanted=signals,
            histories=histories,
            turns=turns,
        ),
        turns=turns,
        spin=spins,
        passage=passage,
        buckling=_buckling(mechanism, built, spins),
        notes=[*moved, *found.findings()],
        independent=found.independent,
        refused=refused,
        functions=tuple(functions[name] for name in built.callers),
    )


def _buckling(
    mechanism: "Mechanism", built: BuiltMechanism, spin: SpinMonitor
) -> BucklingMonitor | None:
    """Return the monitor of the bodies that have second-order data; None without any."""
    bodies = [
        i
        for i, name in enumerate(built.body_names)
        if name in built.packages and built.packages[name].second_order is not None
    ]
    if not bodies:
        return None
    solver, tables = mechanism.solver, built.model
    if not solver.geometric_stiffening:
        tables = build(mechanism, dict(built.packages), stiffening=True).model
    stop = solver.on_invalid == "stop"
    return BucklingMonitor(built.model, tables, bodies, spin, solver.t_end, stop)
