"""A mechanism that moves from one communication point to the next, with inputs in between."""

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..dynamics.elements.forces.table import unit_of_law
from ..dynamics.elements.joints.contract import Displacement
from ..dynamics.elements.joints.table import JOINTS
from ..dynamics.evaluation.accelerations import assemble
from ..dynamics.evaluation.instants import started
from ..dynamics.evaluation.laws import law_values
from ..dynamics.model.model import Model
from ..errors import InputError
from ..inputs.case.expressions import drives, is_along, law
from ..integrators.choice import make_integrator, tolerances
from ..integrators.generic.base import Integrator
from ..integrators.generic.drive import Watch
from ..integrators.radau import Radau
from ..integrators.table import INTEGRATORS
from ..math.arrays import Array
from ..math.laws import N_COEFFICIENT
from ..mechanism.built_mechanism import BuiltMechanism
from ..mechanism.consistent import described_gaps
from ..signals import recorded
from .inputs import RunSpec
from .preparation import Prepared, prepare

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism


# An input between communication points, from the values that came so far.

KEPT = 3  # values, enough for a parabola
UNKNOWN = np.full(2, np.nan)  # rates of an input


class Course:
    """Polynomials in time for one input, each of one communication step.

    Only the past of an input is known, so a step uses the polynomial of `order` 0, 1 or 2 through
    its last values. A force takes it as it is. A drive is part of a constraint and must not jump:
    it goes by a polynomial of degree 5 from where it stands to the value, rate and acceleration
    that the polynomial has at the end of the step. Both have the same error, the third derivative
    of the input times h^3 for order 2.

    Parameters
    ----------
    drive : continuous with two derivatives
    order : of the polynomial
    start : (3,) value, rate, acceleration at t = 0
    """

    def __init__(self, start: Array, *, drive: bool, order: int) -> None:
        self._drive, self._order = drive, order
        self._at = np.array(start, dtype=float)  # of a drive, where it stands
        self._times: list[float] = []
        self._values: list[float] = []

    def piece(self, t: float, h: float, value: float, rates: Array) -> Array:
        """Return coefficients (3 or 6,) of powers of the time after t, for a step of h [s].

        Parameters
        ----------
        t : time [s]
        h : length of the communication step [s]
        value : value of the input at t
        rates : first and second derivative at t (2,); nan where not known
        """
        if self._order == 0 and not self._drive and rates is UNKNOWN:
            return np.array([value, 0.0, 0.0])
        if not self._times:
            # As if it had followed the parabola of its start before t.
            rate, acceleration = self._at[1:]
            for back in (-2.0 * h, -h):
                past = value + rate * back + 0.5 * acceleration * back**2
                self._note(t + back, float(past))
        self._note(t, value)
        ahead = self._ahead(t, value, rates)
        if not self._drive:
            return ahead
        end = np.array(
            [
                ahead[0] + ahead[1] * h + ahead[2] * h * h,
                ahead[1] + 2.0 * ahead[2] * h,
                2.0 * ahead[2],
            ]
        )
        rows = _join(self._at, end, h)
        self._at = end
        return rows

    def _note(self, t: float, value: float) -> None:
        self._times, self._values = [*self._times, t][-KEPT:], [*self._values, value][-KEPT:]

    def jump(self) -> None:
        """Forget the past of a force, which jumps to its next value; a drive never does."""
        if not self._drive:
            self._times, self._values, self._at = [], [], np.zeros(3)

    def copy(self) -> "Course":
        """Return a course that goes on from here by itself."""
        course = copy(self)
        course._at = self._at.copy()
        return course

    def _ahead(self, t: float, value: float, rates: Array) -> Array:
        """Return coefficients (3,) of the polynomial through the last values."""
        count = self._order + 1
        since = np.array(self._times[-count:]) - t
        derivatives = np.zeros(3)
        derivatives[0] = value
        known = np.isfinite(rates)
        if known[0]:
            derivatives[1] = rates[0]
            if known[1]:
                derivatives[2] = 0.5 * rates[1]
            elif self._order == 2:
                derivatives[2] = (self._values[-2] - value - rates[0] * since[-2]) / since[-2] ** 2
        elif count > 1:
            rows = since[:-1, None] ** np.arange(1, count)
            change = np.array(self._values[-count:-1]) - value
            derivatives[1:count] = np.linalg.solve(rows, change)
        return derivatives


def _join(begin: Array, end: Array, h: float) -> Array:
    """Return coefficients (6,) of the quintic from (3,) to (3,) value, rate, acceleration in h."""
    c = np.zeros(6)
    c[:3] = begin[0], begin[1], 0.5 * begin[2]
    gap = end[0] - (c[0] + c[1] * h + c[2] * h * h)
    rate = (end[1] - (c[1] + 2.0 * c[2] * h)) * h
    acceleration = (end[2] - begin[2]) * h * h
    c[3] = (10.0 * gap - 4.0 * rate + 0.5 * acceleration) / h**3
    c[4] = (-15.0 * gap + 7.0 * rate - acceleration) / h**4
    c[5] = (6.0 * gap - 3.0 * rate + 0.5 * acceleration) / h**5
    return c


# What another program can write: laws of drives, of loads and of actuators.

NEVER = 1e300  # [s], beginning of pieces that are out of use


@dataclass(frozen=True)
class Input:
    """One law that is written from outside.

    Attributes
    ----------
    name : key of the case: "joints.hinge.drive", "forces.push"
    unit : rad, m, N or N m
    law : number of the law in the model
    offset : what the law of the model is above the value of the case [m]
    drive : whether it is a drive, which must not jump; otherwise a force or torque
    start : (3,) value, rate and acceleration of the law of the case at t = 0
    """

    name: str
    unit: str
    law: int
    offset: float
    drive: bool
    start: Array


def inputs_of(mechanism: "Mechanism", built: BuiltMechanism) -> list[Input]:
    """Return all drives, then all forces that have a law of time, in the order of the case.

    A force by an expression is part of the mechanism, and no input.
    """
    values = law_values(built.model, 0.0)
    return [*_drives(mechanism, built, values), *_forces(mechanism, built, values)]


def _drives(mechanism: "Mechanism", built: BuiltMechanism, values: Array) -> Iterator[Input]:
    for name, joint in mechanism.joints.items():
        its = built.joints[name]
        for row, key in zip(its.rows[1:], drives(joint), strict=True):
            coordinate, offset = JOINTS[joint.kind].drives[key].drive.coordinate, 0.0
            if isinstance(coordinate, Displacement):
                offset = float(its.shift[coordinate.axis])
            number = int(built.model.joint_law[row])
            start = values[number] - [offset, 0.0, 0.0]
            yield Input(f"joints.{name}.{key}", coordinate.unit, number, offset, True, start)


def _forces(mechanism: "Mechanism", built: BuiltMechanism, values: Array) -> Iterator[Input]:
    for k, (name, force) in enumerate(mechanism.forces.items()):
        number = int(built.model.force_law[k])
        if is_along(force) or law(force) is None or number < 0:
            continue
        yield Input(f"forces.{name}", unit_of_law(force.kind), number, 0.0, False, values[number])


def shift_law(model: Model, number: int, by: float) -> None:
    """Add a constant to a law, in the arrays of the model; one by an expression becomes a parabola.

    What the law does later stays known to the scales of the run (dynamics/analysis/recovery.py).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    number : number of the law
    by : the constant
    """
    if model.quantities.law[number] >= 0:
        value, rate, acceleration = law_values(model, 0.0)[number]
        write_piece(model, number, 0.0, np.array([value, rate, 0.5 * acceleration]))
    model.law_coefficient[model.law_start[number] : model.law_start[number + 1], 0] += by


def write_piece(model: Model, number: int, t: float, coefficients: Array) -> None:
    """Let a law be a polynomial of the time after t [s], in the arrays of the model.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    number : number of the law
    t : begin of the polynomial [s]
    coefficients : coefficients of ascending powers (k,)
    """
    first, end = int(model.law_start[number]), int(model.law_start[number + 1])
    model.quantities.law[number] = -1
    model.law_time[first + 1 : end] = NEVER
    model.law_time[first] = t
    model.law_coefficient[first] = 0.0
    model.law_coefficient[first, : min(len(coefficients), N_COEFFICIENT)] = coefficients


def write_course(model: Model, given: Input, t: float, coefficients: Array) -> None:
    """Let an input be a polynomial of the time after t [s], in values of the case, which go.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    given : the input
    t : begin of the polynomial [s]
    coefficients : coefficients of ascending powers (k,), in units of the case
    """
    coefficients[0] += given.offset
    write_piece(model, given.law, t, coefficients)


# A mechanism that moves from one communication point to the next, with inputs in between.

DRIVE_ORDER, FORCE_ORDER = 2, 1
UNSEEN = 400  # steps of the integrator after which the monitors look, whatever `every` is
ALLOWED = 1e-6  # gap of a joint in a state that another program gives [m, rad, m/s, rad/s]


class Kept(NamedTuple):
    """All that the steps to come of a run depend on."""

    t: float
    y: Array
    mark: Any  # of the integrator
    integrator: Any
    courses: list[Course]
    laws: tuple[Any, ...]
    memory: dict[Any, Any]
    turns: Any
    prepared: Prepared
    owner: "Stepper"
    last: "Moved | None"  # which led here; of no use to the steps to come, but to derivatives


class Moved(NamedTuple):
    """The last communication step, from its beginning."""

    before: Kept
    t: float
    values: Array
    rates: Array | None
    to_event: bool


class Stepper:
    """A run under way in the hands of another program.

    Steps of the integrator end at every communication point, and it goes on from there as from a
    start. Outputs are those at the end of the step.

    Parameters
    ----------
    spec : the run; its laws of inputs are of use for the start and for the tolerances only
    inputs : names of those that are written from outside; None: all. The others follow the case
    every : the monitors look at the first communication step, and then at one of so many. A look
        costs as much as ten steps or more
    fixed_step : of the integrator [s], without error control; None: by the tolerances
    retraces : keep what `retraced` needs
    sparing : vibrations that communication points cannot show are judged by their displacements
        (Radau.shown_by)

    Raises
    ------
    InputError
        An unknown input; an integrator that cannot restart at communication points.
    """

    t: float  # [s]
    y: Array  # (n,) state
    prepared: Prepared  # the mechanism and its start, of the inputs at t = 0
    _memory: dict[Any, Any]  # of signals
    _started: bool  # the prepared mechanism has been started from
    _integrator: Integrator | None  # from the first step on
    last: Moved | None  # communication step, where it can be retraced
    _moves: int  # communication steps
    _looked: int  # steps of the integrator at the last look of the monitors

    def __init__(
        self,
        spec: RunSpec,
        inputs: Sequence[str] | None = None,
        *,
        every: int = 1,
        fixed_step: float | None = None,
        retraces: bool = False,
        sparing: bool = False,
    ) -> None:
        self._spec, self._every, self._fixed_step = spec, every, fixed_step
        self._retraces, self._sparing = retraces, sparing
        _require_restarts(spec)
        self._begin(prepare(spec.mechanism, spec.packages))
        own = self.prepared
        # By the laws of the case, whatever the inputs are at a start.
        self._atol = tolerances(own.model, own.y0, own.mechanism.solver)
        self._started = False
        known = {signal.name: signal for signal in inputs_of(spec.mechanism, self.prepared.built)}
        for name in inputs or ():
            if name not in known:
                raise InputError(f"{name}: no such input; expected some of {', '.join(known)}")
        self.inputs: list[Input] = [
            signal for name, signal in known.items() if inputs is None or name in inputs
        ]
        # One that looks at a whole run before it has values cannot be an output.
        looking = [n for n, sensor in self.prepared.measured.items() if sensor.look is not None]
        self.left_out = tuple(looking)
        self.outputs = {
            name: sensor for name, sensor in self.prepared.measured.items() if name not in looking
        }

    def start(
        self,
        values: Array | None = None,
        *,
        drive_order: int = DRIVE_ORDER,
        force_order: int = FORCE_ORDER,
    ) -> Array:
        """Close the joints with these inputs (k,) at t = 0; return the outputs (n,).

        Parameters
        ----------
        values : inputs at t = 0 (k,); None: those of the case
        drive_order : order of the polynomials of drives between communication points, 0, 1 or 2
        force_order : the same of forces

        Raises
        ------
        InputError
            A mechanism that cannot be assembled.
        """
        own = np.array([given.start[0] for given in self.inputs])
        change = np.zeros(len(own)) if values is None else values - own

        def adjust(model: Model) -> None:
            for given, by in zip(self.inputs, change, strict=True):
                if by:
                    shift_law(model, given.law, float(by))

        if change.any() or self._started:  # otherwise prepared when it was made
            self._begin(prepare(self._spec.mechanism, self._spec.packages, adjust=adjust))
        self._started, self._orders = True, (force_order, drive_order)
        self._set_courses(change)
        return self.measured()

    def _set_courses(self, change: Array) -> None:
        self._courses = [
            Course(
                given.start + np.array([by, 0.0, 0.0]),
                drive=given.drive,
                order=self._orders[given.drive],
            )
            for given, by in zip(self.inputs, change, strict=True)
        ]

    def jump(self) -> None:
        """Let forces jump to their next values, whatever their past."""
        for course in self._courses:
            course.jump()

    def move(
        self, t: float, values: Array, rates: Array | None = None, *, to_event: bool = False
    ) -> bool:
        """Move on to t [s], or to the first event before; return whether it is an event.

        Parameters
        ----------
        values : (k,) inputs at the present time
        rates : (k, 2) their first and second derivatives; nan, or None: unknown
        to_event : end at the instant of an impact

        Raises
        ------
        InputError
            The run cannot go on; the message says why. `t` and `y` are those of its last step.
        """
        if t <= self.t:  # a step below the spacing of numbers there
            return False
        if self._retraces:
            before = self.kept()._replace(last=None)  # no chain of all steps
            self.last = Moved(before, t, values.copy(), rates, to_event)
        taken = self._integrator.counters.steps if self._integrator is not None else 0
        watched = self._moves % self._every == 0 or taken - self._looked >= UNSEEN
        if watched:
            self._looked = taken
        self._moves += 1
        return self._move(t, values, rates, self._watch if watched else None, to_event=to_event)

    def retraced(self, watch: Watch) -> None:
        """Take the last communication step again, with stages for `watch`; come out as before."""
        end, last = self.kept(), self.last
        assert last is not None
        self.restore(last.before)
        self._move(last.t, last.values, last.rates, watch, to_event=last.to_event, stages=True)
        self.restore(end)

    def inputs_at(self, model: Model, k: int, by: float) -> Model:
        """Return a model whose input k was larger in the last communication step.

        Parameters
        ----------
        model : model whose arrays are copied
        k : number of the input
        by : difference of its value
        """
        assert self.last is not None
        given, before = self.inputs[k], self.last.before
        model = model._replace(
            law_time=model.law_time.copy(),
            law_coefficient=model.law_coefficient.copy(),
            quantities=model.quantities._replace(law=model.quantities.law.copy()),
        )
        course, rates = before.courses[k].copy(), self.last.rates
        value, h = float(self.last.values[k]) + by, self.last.t - before.t
        piece = course.piece(before.t, h, value, UNKNOWN if rates is None else rates[k])
        write_course(model, given, before.t, piece)
        return model

    def kept(self) -> Kept:
        """Return all that the steps to come depend on."""
        integrator: Any = self._integrator
        return Kept(
            self.t,
            self.y.copy(),
            None if integrator is None else integrator.mark(),
            integrator,
            [course.copy() for course in self._courses],
            tuple(array.copy() for array in self._laws()),
            dict(self._memory),
            self.prepared.turns.mark(),
            self.prepared,
            self,
            self.last,
        )

    def restore(self, kept: Kept) -> None:
        """Go on from a state of this run, to the last bit as from there the first time.

        Raises
        ------
        InputError
            A state of another run.
        """
        if not (isinstance(kept, Kept) and kept.owner is self):
            raise InputError("state: expected one of this simulation")
        if kept.prepared is not self.prepared:  # of before another start
            self._begin(kept.prepared)
        prepared = self.prepared
        for array, values in zip(self._laws(), kept.laws, strict=True):
            array[...] = values
        self.t, self.y, self.last = kept.t, kept.y.copy(), kept.last
        self._courses = [course.copy() for course in kept.courses]
        self._memory = dict(kept.memory)
        prepared.turns.go_back(kept.turns)
        self._integrator = kept.integrator
        if kept.integrator is not None:
            kept.integrator.go_back(kept.mark)

    def _laws(self) -> tuple[Any, ...]:
        """Return the arrays of the model that inputs are written into."""
        model = self.prepared.model
        return model.law_time, model.law_coefficient, model.quantities.law

    def place(self, y: Array, values: Array) -> None:
        """Go on from another state y (n,), with inputs (k,), as from a start at t = 0.

        Raises
        ------
        InputError
            Drives, couplings or joints of loops do not allow it; the run stands where it was.
        """
        before, model, names = self.kept(), self.prepared.model, self.prepared.built.joint_names
        change = values - np.array([given.start[0] for given in self.inputs])
        for given, by in zip(self.inputs, change, strict=True):
            powers = given.start * [1.0, 1.0, 0.5]
            powers[0] += by
            write_course(model, given, 0.0, powers)
        y = started(model, 0.0, y)
        equations = assemble(model, 0.0, y)
        rates = equations.Phi_q @ y[model.n_pos : model.n_pos + model.n_vel] + equations.Phi_t
        for what, gaps, units in (
            ("positions", equations.Phi, ("m", "rad")),
            ("rates", rates, ("m/s", "rad/s")),
        ):
            if apart := described_gaps(model, gaps, names, units, ALLOWED):
                self.restore(before)
                raise InputError(
                    f"{what} that drives, couplings or joints do not allow, with a gap in {apart}; "
                    "expected others. The inputs move drives"
                )
        self._set_courses(change)
        self.t, self.y = 0.0, y
        self._integrator, self._memory = None, {}
        self.prepared.turns.go_back(({}, [], []))

    def warnings(self) -> list[str]:
        """Return what the monitors have found since the last call."""
        prepared = self.prepared
        findings = [*prepared.notes, *prepared.spin.findings, *prepared.passage.findings]
        findings += prepared.buckling.findings if prepared.buckling is not None else []
        texts = [f"[{finding.code}] {finding.text}" for finding in findings]
        fresh = [text for text in texts if text not in self._reported]
        self._reported.update(fresh)
        return fresh

    def _begin(self, prepared: Prepared) -> None:
        self.prepared, self._watch = prepared, prepared.watch
        self._integrator = None
        self.t, self.y = 0.0, prepared.y0
        self._memory = {}
        self._reported: set[str] = set()
        self._moves = self._looked = 0
        self.last = None

    def _move(
        self,
        t: float,
        values: Array,
        rates: Array | None,
        watch: Watch | None,
        *,
        to_event: bool,
        stages: bool = False,
    ) -> bool:
        prepared = self.prepared
        if self._integrator is None:
            if prepared.refused is not None:
                raise InputError(prepared.refused.message)
            self._integrator = make_integrator(
                prepared.model,
                self.y,
                prepared.mechanism.solver,
                prepared.treatment,
                fixed_step=self._fixed_step,
                atol=self._atol,
            )
        integrator: Any = self._integrator
        h, known = t - self.t, [UNKNOWN] * len(values) if rates is None else rates
        for given, course, value, its in zip(
            self.inputs, self._courses, values, known, strict=True
        ):
            piece = course.piece(self.t, h, float(value), its)
            write_course(prepared.model, given, self.t, piece)
        integrator.go_on(t)
        if self._sparing and isinstance(integrator, Radau):
            integrator.shown_by(h)
        integrator.keeps_stages = stages
        nowhere, happened = (np.empty(0), np.empty((0, integrator.n))), False
        while integrator.status == "running" and not (happened and to_event):
            integrator.stride(*nowhere, 0, watch is not None)
            request = None
            if watch is not None:
                request = watch(integrator.steps_taken())
                integrator.take_up()
            self.t, self.y, happened = integrator.t, integrator.y, integrator.at_event
            if request is not None:
                raise InputError(request.message)
        if integrator.status not in ("finished", "running"):
            raise InputError(integrator.message)
        return bool(integrator.status == "running")

    def measured(self) -> Array:
        """Return the outputs at the present time, (n,)."""
        block = np.array([self.t]), self.y[None]
        _, values_of_signals = next(
            recorded(self.outputs, self.prepared.model, lambda: [block], self._memory)
        )
        return np.array([values[0] for _, values in values_of_signals])


def _require_restarts(spec: RunSpec) -> None:
    """Raise InputError for integrators that need what was before a communication point."""
    name = spec.mechanism.solver.integrator
    if not INTEGRATORS[name].samples:
        able = [f'"{other}"' for other, kind in INTEGRATORS.items() if kind.samples]
        raise InputError(
            f'solver.integrator = "{name}": goes on from earlier steps, which inputs that change '
            f"at communication points do not allow; expected {' or '.join(able)}"
        )
