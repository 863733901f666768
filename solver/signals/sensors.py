"""Sensors of a mechanism, created before the run so that errors are reported early."""

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..dynamics.elements.joints.table import COORDINATES
from ..dynamics.model.model import Model
from ..errors import InputError
from ..inputs.case.record import needed, with_parts
from ..math.arrays import Array
from ..mechanism import BuiltMechanism
from ..package import ModalPackage
from ..strength.fatigue import StressLife, Turning, fatigue_summary, rainflow_cycles
from .joints import force_values, joint_coordinate, reaction
from .points import POINT_UNITS, point_values
from .sections import Look, Values, ply_stress_values, resultant_values, stress_life
from .strength import strength_values
from .turns import Turns

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import Signal
    from .sections import Materials


Measuring = Callable[[str], tuple[str, Values, Look | None]]  # by name: unit, values, look
# Of each other run: its times (n,) and its signals by name (n,).
Histories = Mapping[str, tuple[Array, Mapping[str, Array]]]


def combined(
    name: str, signal: Any, measuring: Measuring, histories: Histories
) -> tuple[str, Values, Look | None]:
    """Return unit, values and look of a difference or a norm.

    Raises
    ------
    InputError
        Signals of different units.
    """
    names = signal.of if signal.kind == "norm" else [signal.of]
    found = [measuring(part) for part in names]
    looks = [look for _, _, look in found if look is not None]
    units = [unit for unit, _, _ in found]
    terms = [values for _, values, _ in found]
    if signal.run is not None:
        there = names if signal.kind == "norm" else [signal.minus or signal.of]
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
    return lambda recording: one(recording) - two(recording)


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


@dataclass(frozen=True)
class Sensor:
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
                unit, values = "-", _divided(values, signal.divide_by)
            measured[name] = unit, values, look
        return measured[name]

    found = {}
    for name, signal in signals.items():
        if (wanted is not None and name not in wanted) or (
            histories is None and needed(with_parts([name], signals))
        ):
            continue
        unit, values, look = measuring(name)
        life = None
        if signal.kind == "ply_stress":
            life = stress_life(materials or {}, built.packages[signal.body], signal)
        scale = signal.divide_by or 1.0
        found[name] = Sensor(unit, signal.description, values, look, life, scale)
    return found


def recorded(
    sensors: Mapping[str, Sensor],
    model: Model,
    blocks: Callable[[], Iterable[tuple[Array, Array]]],
    memory: dict[Any, Any] | None = None,
) -> Iterator[tuple[Recording, Iterator[tuple[str, Array]]]]:
    """Yield recordings of k states and names and values of the sensors (k,), block by block.

    blocks : gives times and states; called again for sensors that look at all of them before
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


def fatigue_entry(sensor: Sensor, turning: Turning) -> dict[str, Any]:
    """Return the fatigue of a stress with an S-N line, from its turning points in SI."""
    assert sensor.life is not None
    return fatigue_summary(rainflow_cycles(turning.points().tolist()), sensor.life)


def _measuring(
    built: BuiltMechanism, name: str, signal: "Signal", turns: Turns | None
) -> tuple[str, Values, Look | None]:
    assert signal.kind != "difference"
    assert signal.kind != "norm"
    key = f"signals.{name}"
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
    if signal.kind == "strength_ratio" or signal.kind == "exposure":
        return "-", strength_values(key, *_body(built, signal.body), signal), None
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
