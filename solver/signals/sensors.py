"""Sensors of a mechanism, created before the run so that errors are reported early.

Combined signals are differences and norms, also to the histories of another run. Turns of angles
and orientations are counted on the accepted steps.
"""

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..dynamics.analysis.recovery import Look, Recording, Values
from ..dynamics.elements.joints.table import COORDINATES
from ..dynamics.model.model import Model
from ..errors import InputError
from ..inputs.case.record import needed, with_parts
from ..math.arrays import Array
from ..mechanism.built_mechanism import BuiltMechanism
from ..package import ModalPackage
from ..strength.fatigue import StressLife, Turning, fatigue_summary, rainflow_cycles
from .joints import force_values, joint_coordinate, reaction
from .points import POINT_UNITS, point_values
from .rotor import UNITS, rotor_values

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import Signal
    from .sections import Materials


class Turns:
    """Follows angles (k,) and rotation vectors (k, 3) from step to step.

    Between two output times there may be any number of turns; the steps of an integrator resolve
    them.

    Attributes
    ----------
    times : (k,) output times [s]
    """

    def __init__(self, model: Model) -> None:
        self.times: Array = np.zeros(0)
        self._model = model
        self._memory: dict[object, object] = {}
        self._followed: list[Values] = []
        self._last: list[tuple[Array, Array]] = []  # times and values of the last steps
        self._near: list[Array] = []  # values about which the outputs are

    def mark(self) -> Any:
        """Return what has been followed so far."""
        return dict(self._memory), list(self._last), list(self._near)

    def go_back(self, mark: Any) -> None:
        """Follow on from where `mark` was made."""
        memory, last, near = mark
        self._memory, self._last, self._near = dict(memory), list(last), list(near)

    def whole(self, values: Values) -> Values:
        """Return what gives the same values with the turns of all steps.

        values : gives them with the turns that its own times show
        """
        number = len(self._followed)
        self._followed.append(values)

        def joined(recording: Recording) -> Array:
            value = values(recording)
            near = self._about(number, recording.t, value)
            one, about = (each.reshape(len(value), -1) for each in (value, near))
            size, far = np.linalg.norm(one, axis=1), np.linalg.norm(about, axis=1)
            turned = np.where((size > 0.0)[:, None], one, about)
            axis = turned / np.maximum(np.where(size > 0.0, size, far), 1e-300)[:, None]
            if value.ndim == 1:
                axis[:] = 1.0
            off = ((about - one) * axis).sum(axis=1) / (2.0 * np.pi)
            known, missing = np.isfinite(off), np.zeros(off.size)
            missing[known] = np.round(off[known])
            if known.any():  # behind the last step that was seen: as many as up to there
                last = np.maximum.accumulate(np.where(known, np.arange(off.size), 0))
                missing = missing[last]
            return (one + 2.0 * np.pi * missing[:, None] * axis).reshape(value.shape)

        return joined

    def __call__(self, t: Array, y: Array) -> None:
        """Follow steps with the ends t (k + 1,), y (k + 1, n); the first is that of the last."""
        first = 1 if self._last else 0
        if t.size == first:
            return
        recording = Recording(self._model, t[first:], y[first:], self._memory)
        for number, values in enumerate(self._followed):
            latest = values(recording)
            if not first:
                self._last.append((recording.t, latest))
                self._near.append(np.full((self.times.size, *latest.shape[1:]), np.nan))
            else:
                time, value = self._last[number]
                self._last[number] = (
                    np.concatenate([time[-1:], recording.t]),
                    np.concatenate([value[-1:], latest]),
                )
            begin, end = np.searchsorted(self.times, self._last[number][0][[0, -1]])
            end += end < self.times.size and self.times[end] == recording.t[-1]
            self._near[number][begin:end] = self._between(number, self.times[begin:end])

    def _between(self, number: int, t: Array) -> Array:
        """Return values at times (k,) within the last steps."""
        time, value = self._last[number]
        columns = value.reshape(time.size, -1).T
        interpolated = np.array([np.interp(t, time, column) for column in columns])
        return interpolated.T.reshape(t.size, *value.shape[1:])

    def _about(self, number: int, t: Array, value: Array) -> Array:
        """Return values near those at times (k,); nan where no step was seen."""
        near = np.full(value.shape, np.nan)
        if not self._last:
            return near
        at = np.minimum(np.searchsorted(self.times, t), max(self.times.size - 1, 0))
        if self.times.size:
            known = self.times[at] == t
            near[known] = self._near[number][at[known]]
        time = self._last[number][0]
        recent = np.isnan(near.reshape(t.size, -1)[:, 0]) & (t >= time[0]) & (t <= time[-1])
        near[recent] = self._between(number, t[recent])
        return near


Measuring = Callable[[str], tuple[str, Values, Look | None]]  # by name: unit, values, look
# Of each other run: its times (n,) and its signals by name (n,).
Histories = Mapping[str, tuple[Array, Mapping[str, Array]]]


def combined(
    name: str, signal: Any, measuring: Measuring, histories: Histories
) -> tuple[str, Values, Look | None]:
    """Return unit, values and look of a difference or a norm.

    Parameters
    ----------
    name : name of the signal
    signal : its table in the case
    measuring : returns unit, values and look of a signal by name
    histories : signals of other runs

    Raises
    ------
    InputError
        Signals of different units.
    """
    names = signal.of if signal.kind == "norm" else [signal.of]
    measured = [measuring(part) for part in names]
    looks = [look for _, _, look in measured if look is not None]
    units = [unit for unit, _, _ in measured]
    terms = [values for _, values, _ in measured]
    if signal.run is not None:
        there = names if signal.kind == "norm" else [signal.minus or signal.of]
        units += [measuring(other)[0] for other in there if other not in names]
        terms = [
            _minus(values, _history(histories, signal.run, other))
            for values, other in zip(terms, there, strict=True)
        ]
    elif signal.kind == "difference":
        unit, values, look = measuring(signal.minus)
        units.append(unit)
        looks += [look] if look is not None else []
        terms = [_minus(terms[0], values)]
    if len(set(units)) > 1:
        different = " and ".join(dict.fromkeys(units))
        raise InputError(f"signals.{name}: expected signals of one unit, found {different}")

    def look_all(recording: Recording) -> None:
        for look in looks:
            look(recording)

    total = _norm(terms) if signal.kind == "norm" else terms[0]
    return units[0], total, look_all if looks else None


def _minus(one: Values, two: Values) -> Values:
    def minus(recording: Recording) -> Array:
        with np.errstate(invalid="ignore"):  # strength ratios without stress are infinite
            return np.asarray(one(recording) - two(recording))

    return minus


def _norm(terms: list[Values]) -> Values:
    def norm(recording: Recording) -> Array:
        return np.asarray(np.sqrt(sum(np.square(values(recording)) for values in terms)))

    return norm


def _history(histories: Histories, run: str, name: str) -> Values:
    """Return what gives a signal of another run at the times of a recording; NaN after its end."""
    t, signals = histories[run]

    def values(recording: Recording) -> Array:
        return np.interp(recording.t, t, signals[name], right=np.nan)

    return values


_AXES = {"x": 0, "y": 1, "z": 2}


class Sensor(NamedTuple):
    """One signal.

    Attributes
    ----------
    unit : "-" for a quotient
    values : function of a recording for its values (k,)
    look : function to call with all blocks of a recording before values are asked for; None: none
    life : S-N line of a stress; None: no fatigue
    scale : what values times it are in SI
    """

    unit: str
    description: str
    values: Values
    look: Look | None = None
    life: StressLife | None = None
    scale: float = 1.0


def sensors(
    built: BuiltMechanism,
    signals: Mapping[str, "Signal"],
    materials: "Materials | None" = None,
    *,
    wanted: Container[str] | None = None,
    histories: Histories | None = None,
    turns: Turns | None = None,
) -> dict[str, Sensor]:
    """Return the sensors of the signals of a case (inputs/case/tables/signals.py).

    Parameters
    ----------
    materials : those of the case, for S-N lines; None: no fatigue
    wanted : names of the signals to return; None: all
    turns : counts those of angles on the steps of the run; None: only output times show them
    histories : of the other runs that combined signals read; None: without such signals

    Raises
    ------
    InputError
        A package without resultants or stresses, an unknown ply, a missing Python package.
    """
    measured: dict[str, tuple[str, Values, Look | None]] = {}

    def measuring(name: str) -> tuple[str, Values, Look | None]:
        if name not in measured:
            signal = signals[name]
            if signal.kind == "difference" or signal.kind == "norm":
                unit, values, look = combined(name, signal, measuring, histories or {})
            else:
                unit, values, look = _measuring(built, name, signal, turns)
            if signal.divide_by is not None:
                unit = unit if signal.keep_unit else "-"
                values = _divided(values, signal.divide_by)
            measured[name] = unit, values, look
        return measured[name]

    sensors_by_name = {}
    for name, signal in signals.items():
        if (wanted is not None and name not in wanted) or (
            histories is None and needed(with_parts([name], signals))
        ):
            continue
        unit, values, look = measuring(name)
        life = None
        if signal.kind == "ply_stress":
            from .sections import stress_life

            life = stress_life(materials or {}, built.packages[signal.body], signal)
        scale = signal.divide_by or 1.0
        sensors_by_name[name] = Sensor(unit, signal.description, values, look, life, scale)
    return sensors_by_name


def recorded(
    sensors: Mapping[str, Sensor],
    model: Model,
    blocks: Callable[[], Iterable[tuple[Array, Array]]],
    memory: dict[Any, Any] | None = None,
) -> Iterator[tuple[Recording, Iterator[tuple[str, Array]]]]:
    """Yield recordings of k states and names and values of the sensors (k,), block by block.

    Parameters
    ----------
    sensors : sensors by name of the signal
    model : arrays of the mechanism (dynamics/model/model.py)
    blocks : gives times (k,) and states (k, n), block by block; called again for sensors that look
        at all of them before
    memory : what sensors keep of blocks that were shown in an earlier call
    """
    memory = {} if memory is None else memory
    looking = [sensor.look for sensor in sensors.values() if sensor.look is not None]
    if looking:
        for t, y in blocks():
            recording = Recording(model, t, y, memory)
            for look in looking:
                look(recording)
    for t, y in blocks():
        recording = Recording(model, t, y, memory)
        yield recording, ((name, sensor.values(recording)) for name, sensor in sensors.items())


def fatigue_entry(sensor: Sensor, turning: Turning) -> dict[str, object]:
    """Return the fatigue of a stress with an S-N line, from its turning points in SI."""
    assert sensor.life is not None
    return fatigue_summary(rainflow_cycles(turning.points().tolist()), sensor.life)


def _measuring(
    built: BuiltMechanism, name: str, signal: "Signal", turns: Turns | None
) -> tuple[str, Values, Look | None]:
    assert signal.kind != "difference"
    assert signal.kind != "norm"
    key = f"signals.{name}"
    if signal.kind in ("strength_ratio", "exposure", "ply_stress", "resultant"):
        # Not for runs without such a signal: they start sooner.
        from .sections import ply_stress_values, resultant_values
        from .strength import strength_values
    if signal.kind == "joint":
        values = joint_coordinate(built.joints[signal.joint], signal.coordinate)
        unit = COORDINATES[signal.coordinate].unit
        return unit, turns.whole(values) if turns and unit == "rad" else values, None
    if signal.kind == "reaction":
        vectors = reaction(built.joints[signal.joint], signal)
        unit = "N" if signal.quantity == "force" else "N m"
        return unit, _component(vectors, signal.component), None
    if signal.kind == "force":
        return *force_values(built, signal.of), None
    if signal.kind == "rotor":
        return UNITS[signal.quantity], rotor_values(built, signal.quantity), None
    if signal.kind == "strength_ratio" or signal.kind == "exposure":
        worst = np.min if signal.kind == "strength_ratio" else np.max
        parts = [
            strength_values(key, *_body(built, part), signal)
            for part in signal.segments or [signal.body]
        ]
        return "-", lambda recording: worst([part(recording) for part in parts], axis=0), None
    if signal.kind == "ply_stress":
        return "Pa", *ply_stress_values(key, built, *_body(built, signal.body), signal)
    if signal.kind == "resultant":
        unit = "N" if signal.component.startswith("F") else "N m"
        return unit, resultant_values(key, built, *_body(built, signal.body), signal), None
    vectors = point_values(built, name, signal)
    if turns and signal.kind == "orientation":
        vectors = turns.whole(vectors)
    return POINT_UNITS[signal.kind], _component(vectors, signal.component), None


def _body(built: BuiltMechanism, name: str) -> tuple[int, ModalPackage]:
    """Return number and package of a flexible body."""
    return built.body_names.index(name), built.packages[name]


def _component(vectors: Values, component: str) -> Values:
    if component == "magnitude":
        return lambda recording: np.asarray(np.linalg.norm(vectors(recording), axis=1))
    axis = _AXES[component]
    return lambda recording: vectors(recording)[:, axis]


def _divided(values: Values, by: float) -> Values:
    return lambda recording: values(recording) / by
