"""A run with the derivatives of its motion, and from them those of its signals."""

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...dynamics.elements.forces.limit_stop import LIMIT_STOP
from ...dynamics.evaluation.instants import Instants, beyond, sampled
from ...dynamics.evaluation.reactions import reads_reactions
from ...dynamics.model.coordinates import displaced
from ...errors import InputError
from ...integrators.breakpoints import JUMPS, breaks
from ...integrators.generic.drive import Steps, StopRequest
from ...integrators.radau import Radau
from ...math.arrays import Array
from ...math.expressions import operations as op
from ...math.expressions.operations import Programs
from ...results import Derivative, RunResult, Summary
from ...run.coupled import Stepper
from ...run.execution import Progress
from ...run.inputs import RunSpec
from ...run.outcome import collect
from ...run.preparation import Prepared, integrated, output_times, prepare
from ...run.timing import Stopwatch
from ...signals import HELD, Histories, Recording, Sensor, sensors
from .linear import Column
from .parameters import Parameter, Variant, check_variant, start_tangent, variant
from .tangent import Tangent

SLOW = 1e-4  # of an impact, below which a stop is taken for one at rest [m/s, rad/s]
# Operations that bend or jump where their arguments pass a value.
BENT = frozenset((op.MINIMUM, op.MAXIMUM, op.ABS, op.SIGN, op.FLOOR, op.LESS, op.LESS_EQUAL))
STOP = LIMIT_STOP.kind  # whose bends are located


class _Follower:
    """Watch that carries the tangent along the steps of a run."""

    def __init__(self, prepared: Prepared, tangent: Tangent, times: Array, y: Array) -> None:
        self._watch, self._tangent, self._functions = prepared.watch, tangent, prepared.functions
        self.note = self._watch.note
        self.times = times
        self.S = np.zeros((self.times.size, *tangent.S.shape))
        self.S[0] = tangent.S
        self._still = tangent.is_still
        self._until = float(times[0])  # to where S is known [s]
        self._last, self._sampled = y, float(times[0])  # state; instant of the last sampling [s]
        self._instants = Instants(prepared.model, float(times[-1]))
        self._first = prepared.model.n_pos + prepared.model.n_vel

    def __call__(self, steps: Steps) -> StopRequest | None:
        request = self._watch(steps)
        self.take(steps)
        return request

    def take(self, steps: Steps) -> None:
        """Carry the tangent over steps that follow those before."""
        if len(steps) and not self._still:
            t, y = steps.t, steps.y
            moved, due = not np.array_equal(y[0], self._last), self._instants.sampled_at(t[0]).any()
            if moved or (due and self._sampled < t[0]):
                self._jump(float(t[0]), self._last, y[0])
            begin = 0
            # Ends of steps at which the loop may have sampled.
            within = steps.t if self._instants.t.size else ()
            ends = [k for k, t in enumerate(within) if k and self._instants.sampled_at(t).any()]
            for end in [*ends, len(steps)]:
                if end > begin:
                    self._follow(steps, begin, end)
                begin = end
            self._last = y[-1].copy()

    def _follow(self, steps: Steps, begin: int, end: int) -> None:
        """Carry the tangent over some steps, and the sampling at their end within the loop."""
        assert steps.Z is not None
        assert steps.multipliers is not None
        t, y = steps.t[begin : end + 1], steps.y[begin : end + 1]
        part = replace(
            steps, t=t, y=y, Z=steps.Z[begin:end], multipliers=steps.multipliers[begin:end]
        )
        own, times = of_steps(self.times, self._until, t)
        self.S[own], self._until = self._tangent.follow(part, times), t[-1]
        before = y[-1].copy()
        before[self._first :] = y[-2, self._first :] + steps.Z[end - 1, 2, self._first :]
        which = self._instants.sampled_at(t[-1])
        if which.any():
            model = self._tangent.model
            expected = sampled(model, float(t[-1]), before, which, self._functions)
            if np.array_equal(expected[self._first : -1], y[-1, self._first : -1]):
                self._jump(float(t[-1]), before, y[-1])

    def _jump(self, t: float, before: Array, after: Array) -> None:
        """Carry the tangent over an instant of sampling, or of an impact."""
        model, event, self._sampled = self._tangent.model, -1, t
        which = Instants(model, t + 1.0).sampled_at(t)
        expected = sampled(model, t, before, which, self._functions)
        if model.quantities.event_state.size and not np.array_equal(expected, after):
            gap = np.abs(beyond(model, t, before))
            event = int(np.argmin(gap[:, 0] / np.maximum(gap[:, 1], 1e-300)))
            if gap[event, 1] < SLOW:
                raise InputError(
                    f"t = {t:.6g} s: an impact at {gap[event, 1]:.3g} m/s or rad/s, a stop in "
                    "contact at rest; sensitivities are not implemented beyond it. Expected a "
                    "shorter solver.t_end, or a stop with impact_speed"
                )
        self._tangent.jump(t, before, after, event)


def of_steps(times: Array, until: float, t: Array) -> tuple[NDArray[np.bool_], Array]:
    """Return which times are those of some steps, and these times, within the steps.

    Behind a bend of a law of time, steps begin a bit later than those before it ended.

    Parameters
    ----------
    times : output times [s]
    until : end of the steps before [s]
    t : ends of the steps, their beginning first [s]
    """
    own = (times > until) & (times <= t[-1])
    return own, np.maximum(times[own], np.nextafter(t[0], np.inf))


class Trace:
    """Watch that keeps the steps of a run with their stages, for a tangent that follows later.

    Raises InputError if the tangent of the run is not implemented.
    """

    def __init__(self, prepared: Prepared) -> None:
        require_derivatives(prepared)
        self._watch = prepared.watch
        self.note = self._watch.note
        self.steps: list[Steps] = []

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Keep steps; return what the monitors say of them."""
        request = self._watch(steps)
        assert steps.Z is not None
        assert steps.multipliers is not None
        kept = replace(steps, Z=steps.Z.copy(), multipliers=steps.multipliers.copy())
        self.steps.append(kept)
        return request


@dataclass(frozen=True)
class Followed:
    """A run with the tangent of its motion at the output times.

    Attributes
    ----------
    t, y : (n_t,) [s], (n_t, n)
    S : (n_t, 2 n_vel + n_aux, P) derivatives by the parameters
    pairs : the mechanisms with each parameter less and plus its h
    held : points of plies that govern in the motion itself
    """

    prepared: Prepared
    parameters: Sequence[Parameter]
    t: Array
    y: Array
    S: Array
    pairs: Sequence[tuple[Variant, Variant]]
    held: dict[str, object]

    def recording(self) -> Recording:
        """Return the motion itself; what governs in it is noted."""
        return Recording(self.prepared.model, self.t, self.y, {HELD: self.held})

    def beside(self, p: int) -> Iterator[tuple[Variant, Recording]]:
        """Yield the mechanisms less and plus the h of a parameter, and the motions along S."""
        yield from beside_motion(
            self.prepared, self.t, self.y, self.S[:, :, p], self.parameters[p].h, self.pairs[p],
            self.held,
        )  # fmt: skip


def followed(
    prepared: Prepared,
    parameters: Sequence[Parameter],
    steps: Iterable[Steps],
    y: Array,
    held: dict[str, object],
) -> Followed:
    """Return a run with its tangent at the output times.

    Parameters
    ----------
    prepared : the run
    parameters : the P parameters
    steps : of its trace, with stages
    y : (n_t, n) states at the output times
    held : points of plies that govern in the motion itself
    """
    follower, pairs = _following(prepared, parameters)
    for each in steps:
        follower.take(each)
    return Followed(prepared, parameters, follower.times, y, follower.S, pairs, held)


def sides(
    prepared: Prepared, parameters: Sequence[Parameter]
) -> tuple[list[tuple[Variant, Variant]], list[Column], Array]:
    """Return mechanisms less and plus h of each parameter, their models, and tangents of the start.

    The tangents are (2 n_vel + n_aux, P).

    Raises
    ------
    InputError
        A parameter that changes more than numbers.
    """
    model, pairs, columns = prepared.model, list[tuple[Variant, Variant]](), list[Column]()
    start = np.zeros((2 * model.n_vel + model.n_aux, len(parameters)))
    for p, parameter in enumerate(parameters):
        minus, plus = (variant(each, model) for each in (parameter.minus, parameter.plus))
        for side in (minus, plus):
            check_variant(parameter, side, model, prepared.mechanism.solver.t_end)
        pairs.append((minus, plus))
        columns.append(Column(minus.built.model, plus.built.model, parameter.h))
        start[:, p] = start_tangent(model, prepared.y0, minus.y0, plus.y0, parameter.h)
    return pairs, columns, start


def cuts_of(prepared: Prepared) -> Array | None:
    """Return instants between which laws of time are smooth; None where nobody knows [s]."""
    laws = breaks(prepared.model, prepared.mechanism.solver.t_end)
    cuts = np.concatenate([laws.kinks, laws.narrow, laws.jumps.ravel()])
    return None if laws.unsearched else cuts


def _following(
    prepared: Prepared, parameters: Sequence[Parameter]
) -> tuple[_Follower, list[tuple[Variant, Variant]]]:
    """Return what carries the tangent of a run, and the mechanisms beside it by parameter."""
    pairs, columns, S = sides(prepared, parameters)
    y0, solver = prepared.y0, prepared.mechanism.solver
    tangent = Tangent(prepared.model, columns, y0, S, bends_of(prepared), cuts_of(prepared))
    times = output_times(solver.t_end, solver.output_step)
    return _Follower(prepared, tangent, times, y0), pairs


def with_sensitivities(
    spec: RunSpec,
    parameters: Sequence[Parameter],
    *,
    progress: bool = False,
) -> tuple[RunResult, Summary]:
    """Integrate a run with the derivatives of its motion; return result and summary.

    Parameters
    ----------
    progress : show it

    Raises
    ------
    InputError
        As `prepare`; a run that does not finish; what has no derivative, or one that is not
        implemented, by name.
    KeyboardInterrupt
        A signal has ended it.
    """
    clock = Stopwatch()
    prepared = prepare(spec.mechanism, spec.packages)
    require_derivatives(prepared)
    follower, pairs = _following(prepared, parameters)
    shown = Progress(follower, spec.mechanism.solver.t_end, spec.run, progress)
    try:
        finished = integrated(prepared, shown, stages=True)
    finally:
        shown.close()
    clock.lap("integrate")
    solution = finished.solution
    if solution.status == "interrupted":
        raise KeyboardInterrupt
    if solution.status != "finished":
        raise InputError(f"{spec.run}: sensitivities need a run that finishes: {solution.message}")
    result, summary = collect(spec, prepared.measured, finished, clock.seconds["integrate"])
    y, found_ = np.asarray(solution.y[:]), list[Derivative]()
    motion = Followed(prepared, parameters, solution.t, y, follower.S, pairs, {})
    recording = motion.recording()
    for name, asked in spec.mechanism.signals.items():
        if asked.kind in ("strength_ratio", "exposure") and name in prepared.measured:
            prepared.measured[name].values(recording)
    for p, parameter in enumerate(parameters):
        changes = _of_signals(prepared, motion.beside(p), parameter.h)
        for signal in result.signals:
            unit = f"({signal.unit})/({parameter.unit})" if parameter.unit else signal.unit
            values = changes[signal.name]
            found_.append(Derivative(signal.name, parameter.name, unit, parameter.value, values))
    order = {signal.name: k for k, signal in enumerate(result.signals)}
    found_.sort(key=lambda one: order[one.signal])
    return replace(result, sensitivities=tuple(found_)), summary


TRIED = 1e-4  # displacement for differences of signals, as a share of the mechanism's size, or rad


def step_derivatives(stepper: Stepper) -> Array:
    """Return the derivatives of the outputs by the inputs of the last communication step.

    (n_out, n_in): the state at its beginning is given, the inputs are those of this step, the
    outputs those at its end. By the tangent of the steps that were taken.

    Raises
    ------
    InputError
        No step was taken yet; an impact within it that has no derivative.
    """
    if stepper.last is None:
        raise InputError("derivatives of outputs: expected a step before")
    prepared, (before, t) = stepper.prepared, (stepper.last.before, stepper.t)
    model = prepared.model
    columns = []
    for k, given in enumerate(stepper.inputs):
        h = 1e-5 if given.drive else max(1.0, abs(float(stepper.last.values[k])))
        minus, plus = (stepper.inputs_at(model, k, by) for by in (-h, h))
        columns.append(Column(minus, plus, h))
    start = np.zeros((2 * model.n_vel + model.n_aux, len(columns)))
    tangent = Tangent(model, columns, before.y, start, bends_of(prepared))
    times = np.array([before.t, t])
    follower = _Follower(prepared, tangent, times, before.y)
    stepper.retraced(follower)
    y, held = stepper.y[None], dict[str, object]()
    recording = Recording(model, times[1:], y, {HELD: held})
    for sensor in stepper.outputs.values():
        sensor.values(recording)
    rows = np.zeros((len(stepper.outputs), len(columns)))
    for k, column in enumerate(columns):
        S, n = follower.S[1:, :, k], model.n_vel
        # Positions apart: in a short step they change by far less than velocities, so that one
        # displacement for both would leave rounding errors of the outputs.
        for its in (slice(0, n), slice(n, None)):
            part = np.zeros_like(S)
            part[:, its] = S[:, its]
            moved = np.abs(part[0, : 2 * n].reshape(2, -1) * tangent.units).max(initial=0.0)
            h = TRIED / moved if moved > 0.0 else column.h
            low, high = (
                replace(prepared.built, model=stepper.inputs_at(model, k, by if its.start else 0.0))
                for by in (-h, h)
            )
            pair = Variant(low, y[0]), Variant(high, y[0])
            changes = _of_signals(
                prepared, beside_motion(prepared, times[1:], y, part, h, pair, held), h
            )
            rows[:, k] += [changes[name][0] for name in stepper.outputs]
    return rows


def require_derivatives(prepared: Prepared) -> None:
    """Raise InputError if the tangent of a run is not implemented; names what it is."""
    solver, model, built = prepared.mechanism.solver, prepared.model, prepared.built
    if solver.integrator != Radau.name:
        raise InputError(
            f'solver.integrator = "{solver.integrator}": sensitivities are implemented for '
            f'"{Radau.name}" only'
        )
    if prepared.mechanism.rotor is not None:
        raise InputError("rotor: sensitivities of blades in the wind are not implemented")
    if prepared.mechanism.fidelity is not None:
        raise InputError("fidelity: sensitivities are implemented for runs without a plan only")
    if prepared.refused is not None:
        raise InputError(f"sensitivities: the run does not begin: {prepared.refused.message}")
    quantities = model.quantities
    programs = quantities.programs
    read = [(name, int(quantities.force[k])) for k, name in enumerate(built.force_names)]
    named = np.flatnonzero(quantities.of_coordinate < 0)[: len(built.state_names)]
    for j, label in zip(named.tolist(), built.state_names, strict=False):
        owner = label.rpartition(".")[0]
        read += [(owner, int(each[j])) for each in (quantities.rate, quantities.update)]
    for name, p in read:
        key = f"forces.{name}"
        kind = getattr(prepared.mechanism.forces.get(name), "kind", "")
        if name in built.callers:
            raise InputError(f"{key}: sensitivities of Python functions are not implemented")
        if p >= 0 and kind != STOP and _is_bent(programs, p):
            raise InputError(
                f"{key}: its force or state has a bend or jump where the motion passes a value "
                "(min, max, abs, sign, comparisons, corners of a table or curve), which "
                "sensitivities do not locate; expected a smooth law, as a table with "
                'interpolation = "pchip"'
            )
    if reads_reactions(model):
        raise InputError(
            "forces that read reactions (coefficient of friction in a joint): sensitivities are "
            "not implemented"
        )


def _is_bent(programs: Programs, p: int) -> bool:
    """Tell whether an expression has a bend or jump where what it reads of the motion decides."""
    stack: list[bool] = []  # whether a part reads the motion
    for i in range(int(programs.start[p]), int(programs.start[p + 1])):
        code = int(programs.code[i])
        if code in op.PUSHES:
            stack.append(code == op.LOAD)
            continue
        count = op.operands(code)
        stack, given = stack[:-count], stack[-count:]
        corners = code == op.CURVE and _has_corners(programs, int(programs.argument[i]))
        if any(given) and (code in BENT or corners):
            return True
        stack.append(any(given))
    return False


def _has_corners(programs: Programs, curve: int) -> bool:
    """Tell whether a curve, or its slope, jumps between two of its pieces."""
    own = slice(int(programs.curve_start[curve]), int(programs.curve_start[curve + 1]))
    place, c = programs.curve_place[own], programs.curve_coefficient[own]
    length, powers = np.diff(place)[:, None], np.arange(1, c.shape[1])
    value = (c[:-1] * length ** np.arange(c.shape[1])).sum(axis=1)
    slope = (c[:-1, 1:] * powers * length ** (powers - 1)).sum(axis=1)
    return any(
        bool((np.abs(c[1:, d] - before) > JUMPS * np.abs(c[:, d]).max()).any())
        for d, before in enumerate((value, slope))
    )


def bends_of(prepared: Prepared) -> list[tuple[int, float]]:
    """Return coordinates and the limits of stops along them."""
    along, bends = prepared.model.quantities.along, []
    for name, force in prepared.mechanism.forces.items():
        if force.kind == STOP:
            number = int(along[prepared.built.force_names.index(name)])
            limits = (getattr(force, "lower", None), getattr(force, "upper", None))
            bends += [(number, float(limit)) for limit in limits if limit is not None]
    return bends


def beside_motion(
    prepared: Prepared,
    t: Array,
    y: Array,
    S: Array,
    h: float,
    pair: tuple[Variant, Variant],
    held: dict[str, object],
) -> Iterator[tuple[Variant, Recording]]:
    """Yield mechanisms beside a run, and their motions along a column of its tangent.

    Parameters
    ----------
    prepared : the run
    t, y : (n_t,) [s], (n_t, n) its motion
    S : (n_t, 2 n_vel + n_aux) column of the tangent, or (2 n_vel + n_aux,) for all times
    h : the motions are those at -h S and h S
    pair : the mechanisms at -h and h
    held : points of plies that govern in the motion itself, which stay
    """
    for sign, each in zip((-1.0, 1.0), pair, strict=True):
        moved = displaced(prepared.model, y, sign * h * S)
        yield each, Recording(each.built.model, t, moved, {HELD: held})


def sensors_beside(
    prepared: Prepared,
    each: Variant,
    recording: Recording,
    wanted: Container[str] | None = None,
    histories: Histories | None = None,
) -> dict[str, Sensor]:
    """Return the sensors of a mechanism beside a run, which have looked at its motion.

    Parameters
    ----------
    prepared : the run
    each : mechanism beside it
    recording : its motion
    wanted : names of signals; None: all
    histories : signals of other runs that these read
    """
    signals, materials = prepared.mechanism.signals, prepared.mechanism.materials
    own = sensors(each.built, signals, materials, wanted=wanted, histories=histories)
    for sensor in own.values():
        if sensor.look is not None:
            sensor.look(recording)
    return own


def change_of(low: Array, high: Array, unit: str) -> Array:
    """Return high - low; of angles [rad] that of the same turn.

    Parameters
    ----------
    low, high : values of a signal, of one shape
    unit : of both; differences in "rad" lie within half a turn
    """
    change = high - low
    return (change + np.pi) % (2.0 * np.pi) - np.pi if unit == "rad" else change


def _of_signals(
    prepared: Prepared, beside: Iterable[tuple[Variant, Recording]], h: float
) -> dict[str, Array]:
    """Return the derivatives (k,) of signals by a parameter, with its direct effect on them."""
    low, high = (
        {
            name: sensor.values(recording)
            for name, sensor in sensors_beside(prepared, each, recording).items()
        }
        for each, recording in beside
    )
    return {
        name: change_of(low[name], high[name], sensor.unit) / (2.0 * h)
        for name, sensor in prepared.measured.items()
    }
