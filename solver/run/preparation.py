"""A mechanism ready to be integrated (model, start, monitors, sensors), and its integration."""

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..checks.finished_run import FinishedRun, Look, StepSizes
from ..checks.judge import Monitors
from ..checks.singularity import SingularityMonitor
from ..checks.stability import BucklingMonitor, SpinMonitor
from ..dynamics.analysis.recovery import scales
from ..dynamics.elements.constraints.treatment import Treatment
from ..dynamics.elements.forces.bearing import COEFFICIENT, JAMMING
from ..dynamics.evaluation.accelerations import derivative
from ..dynamics.model.model import Model
from ..errors import few
from ..inputs.case.expressions import is_smooth
from ..inputs.case.record import needed
from ..integrators.choice import make_integrator
from ..integrators.generic.advice import Stall
from ..integrators.generic.drive import Solution, Steps, StopRequest, Watch, integrate
from ..integrators.table import treatment_of
from ..math.arrays import Array
from ..math.records import record
from ..mechanism.assembly import treated
from ..mechanism.build import build, used_packages
from ..mechanism.built_mechanism import BuiltMechanism
from ..mechanism.consistent import redundancy
from ..mechanism.equilibrium import given_spin
from ..mechanism.python_functions import Called, python_functions, require_permission
from ..mechanism.start import moved_findings, starting_state
from ..package import ModalPackage
from ..results.codes import BREAKS_UNSEARCHED, BUDGET_USED, CHATTERS, SINGULAR, Finding
from ..signals import Histories, Sensor, Turns, recorded, sensors
from .inputs import RunSpec
from .timing import work_s

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism
    from ..inputs.case.tables.signals import Signal as SignalTable
    from ..inputs.case.tables.solver import Solver


NOTHING = 1e-13  # of the energy of a mechanism at its speed: round-off
# The energy of a motion is known to a thousandth, the limit of the balance, where its speed is a
# thousand tolerances. Slower motion is noise of the steps, but above a hundredth of the scale.
NOISE, MOST_NOISE = 1e3, 1e-2


@record
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
        """Return the solution, with an explanation if it failed at a singular position, or where
        friction by reactions jams."""
        if solution.status != "failed":
            return solution
        t, y = float(solution.t[-1]), solution.y[-1]
        cause = self.passage.explain(t, y)
        if not cause:
            jam = jammed(self.mechanism, self.built.model, t, y)
            return replace(solution, message=f"{jam}{solution.message}")
        message = f"{cause} ({solution.message})"
        return replace(solution, message=message, code=SINGULAR.name)

    def finished(self, solution: Solution, order: int, look: Look) -> FinishedRun:
        """Return the run as the checks see it; `order` is that of the integrator.

        Parameters
        ----------
        solution : times and states of the run
        order : order of the integrator
        look : at how many output times the checks look
        """
        passage, t_end = self.passage, solution.t[-1]
        # Two monitors may ask for a stop in the same step; what is beyond the earlier one is cut.
        findings = [*self.spin.findings, *passage.findings]
        if self.buckling is not None:
            findings += self.buckling.findings
        met = [f for f in findings if f.t is None or f.t <= t_end]
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
    units: str = "m",
) -> Prepared:
    """Build a checked mechanism (inputs/case/tables/schema.py), close its joints, look at it.

    `signals` are those that will be asked for; None: all. `allow_python`: functions of the user
    may run. `adjust` may write into the arrays of the model before its joints are closed.
    `histories` of other runs as in `sensors`.

    Parameters
    ----------
    mechanism : tables of the case, checked
    packages : modal packages of the bodies by name
    signals : names of the signals that will be asked for; None: all
    allow_python : functions of the user may run
    adjust : function that writes into the arrays of the model before its joints are closed
    histories : signals of other runs
    units : of lengths in the case file, for messages with values to give there

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
    moved = moved_findings(mechanism, built, y0, units)
    redundant = redundancy(built.model, y0, built.joint_names, t_end=solver.t_end)
    built = replace(
        built, model=treated(built.model, treatment)._replace(redundant=redundant.count)
    )
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
        notes=[*moved, *redundant.findings()],
        independent=redundant.independent,
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


# Integration of a prepared mechanism over its output times.


def output_times(t_end: float, step: float) -> Array:
    """Return 0, step, 2 step, ..., t_end, (k,) [s]; the last interval may be shorter."""
    count = int(np.floor(t_end / step * (1 + 1e-12)))
    times = np.linspace(0.0, count * step, count + 1)
    if t_end - times[-1] > 1e-9 * t_end:
        times = np.append(times, t_end)
    times[-1] = t_end
    return times


def integrated(
    prepared: Prepared,
    watch: Watch | None = None,
    look: Look | None = None,
    on_stall: Callable[[Stall], None] | None = None,
    on_note: Callable[[Finding], None] | None = None,
    folder: Path | None = None,
    *,
    stages: bool = False,
) -> FinishedRun:
    """Integrate a prepared mechanism from its start to `t_end`: a single run, or one of a sweep.

    Numerical trouble and Ctrl-C while it steps are no exceptions but the status of the solution.

    Parameters
    ----------
    watch : sees the steps in place of the monitors, which it must call itself
    look : at how many output times the checks look
    on_stall : called at once when a run has come to a stall
    on_note : called at once when a law chatters
    folder : for states that are too many for memory; None: that of temporary files
    stages : of `radau`, whether the steps that `watch` sees have their stages
    """
    solver = prepared.mechanism.solver
    solution, order = prepared.refused, 0
    if solution is None:
        integrator = make_integrator(
            prepared.model,
            prepared.y0,
            solver,
            prepared.treatment,
            functions=prepared.functions,
        )
        if stages:
            integrator.keeps_stages = True  # type: ignore[attr-defined]
            integrator.over_bends = True  # the tangent divides steps there
        if integrator.unsearched:
            prepared.notes.append(_unsearched(integrator.unsearched))
        times = output_times(solver.t_end, solver.output_step)
        prepared.turns.times = times

        def on_chatter(program: int, t: float) -> None:
            prepared.notes.append(_chatters(prepared.built, program, t))
            if on_note is not None:
                on_note(prepared.notes[-1])

        solution = integrate(
            integrator,
            times,
            watch=watch or prepared.watch,
            on_stall=on_stall,
            on_chatter=on_chatter,
            folder=folder,
        )
        if integrator.most_hidden <= 0:
            prepared.notes.append(_unseen(type(integrator).most_hidden))
        if solution.code == CHATTERS.name:
            k = [note.code for note in prepared.notes].index(CHATTERS.name)
            first = prepared.notes[k]
            text = f"{first.text}. {solution.message}"
            prepared.notes[k] = first._replace(level="error", text=text)
        order = integrator.order
    return prepared.finished(prepared.explained(solution), order, look or Look())


def jammed(mechanism: "Mechanism", model: Model, t: float, y: Array) -> str:
    """Say which friction leaves no accelerations at time t [s] in state y (n,); "" if none does.

    Parameters
    ----------
    mechanism : tables of the case
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    friction = []
    for name, force in mechanism.forces.items():
        keys = {key: getattr(force, key, None) for key in ("joint", *JAMMING)}
        if keys[COEFFICIENT]:
            given = ", ".join(f"{k} = {v}" for k, v in keys.items() if v is not None)
            friction.append(f"forces.{name} ({given})")
    if not friction or np.isfinite(derivative(model, t, y)).all():
        return ""
    return (
        f"Friction would need more reaction than there is, so that a body jams: {few(friction)}. "
        "Expected a longer guide (`length`), a smaller coefficient, or loads and centres of mass "
        "nearer to the axis of the joint. "
    )


def _unsearched(count: int) -> Finding:
    text = (
        f"{count} of the expressions of the time may break at more than 50,000 instants: no step "
        "ends there, and short pulses may be stepped over; write the breaks as a table, give "
        "`max_step`, or a shorter `t_end`"
    )
    return BREAKS_UNSEARCHED.finding(text, value=count)


def _unseen(count: int) -> Finding:
    text = (
        f"a force by an expression varied unseen inside of {count} steps, which then ended there; "
        "later ones do not, and narrow forces may be stepped over: give `max_step`, or a smaller "
        "rtol"
    )
    return BREAKS_UNSEARCHED.finding(text, value=count)._replace(limit=float(count))


def _chatters(built: BuiltMechanism, program: int, t: float) -> Finding:
    """Return what to say of an expression that has begun to chatter at time t [s]."""
    model, read = built.model, built.model.quantities
    of_law = np.flatnonzero(read.law == program)
    forces = np.flatnonzero((read.force == program) | np.isin(model.force_law, of_law))
    whose = few([built.force_names[k] for k in forces]) if forces.size else "an expression"
    text = (
        f"{whose}: from t = {t:.6g} s on the force jumps back and forth as fast as the tolerance "
        "lets steps see it: its jump holds the motion (sliding), and the run takes tiny steps or "
        "is inaccurate. Give the jump a width, as clip(s / width, -1, 1) in place of sign(s), or "
        "sample the law (`sample_time` of a controller)"
    )
    return CHATTERS.finding(text, t=t)


@dataclass(eq=False, repr=False)
class Allowance:
    """Watch that ends a run with its CPU time.

    Attributes
    ----------
    monitors : of the run
    t_end : end of the run [s]
    seconds : CPU time for it
    """

    monitors: Watch
    t_end: float
    seconds: float
    begin: float = field(default_factory=work_s)

    @property
    def note(self) -> Callable[[float, Array], bool]:
        """As of the monitors; see `Watch`."""
        return self.monitors.note

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Show steps to the monitors; ask for the end where the time is used up."""
        request, t, taken = self.monitors(steps), float(steps.t[-1]), work_s() - self.begin
        if request is not None or taken <= self.seconds or t >= self.t_end:
            return request
        whole = taken * self.t_end / t
        text = f"its {max(self.seconds, 0.0):.2g} s of CPU time are used up; the whole run takes "
        return StopRequest(t, f"{text}about {whole:.2g} s", BUDGET_USED.name)


def complete(prepared: Prepared, seconds: float = np.inf) -> FinishedRun:
    """Integrate a run that serves another purpose than its own results: a part of it is no use.

    It stops when it has taken `seconds` of CPU time.

    Raises
    ------
    KeyboardInterrupt
        A signal has ended it. `integrated` keeps its part.
    """
    limit = Allowance(prepared.watch, prepared.mechanism.solver.t_end, seconds)
    finished = integrated(prepared, limit)
    if finished.solution.status == "interrupted":
        raise KeyboardInterrupt
    return finished


# Other runs that the combined signals of a run read: they are integrated with it.


def histories_of(
    signals: Mapping[str, "SignalTable"],
    runs: Mapping[str, RunSpec],
    solver: "Solver",
    *,
    allow_python: bool = False,
    integrate: "Callable[[str, Prepared], FinishedRun] | None" = None,
) -> Histories:
    """Return times and signals of the other runs that signals read, at the times of this one.

    A run that ends early has fewer times.

    Parameters
    ----------
    signals : of a case; those of them that are combined
    runs : the other runs by name
    solver : keys of this run
    integrate : in place of `complete`, with the name of the run

    Raises
    ------
    InputError
        As `prepare`, of another run.
    """
    histories: dict[str, tuple[Array, dict[str, Array]]] = {}
    for run, names in needed(signals).items():
        other, own = runs[run], runs[run].mechanism.solver
        shared = {"output_step": solver.output_step, "t_end": min(own.t_end, solver.t_end)}
        if any(getattr(own, key) != value for key, value in shared.items()):
            other = other.changed({f"solver.{key}": value for key, value in shared.items()})
        prepared = prepare(other.mechanism, other.packages, names, allow_python=allow_python)
        finished = complete(prepared) if integrate is None else integrate(run, prepared)
        recordings = recorded(prepared.measured, finished.model, finished.blocks)
        blocks = [(recording, dict(rows)) for recording, rows in recordings]
        values = {name: np.concatenate([v[name] for _, v in blocks]) for name in names}
        histories[run] = np.concatenate([r.t for r, _ in blocks]), values
    return histories
