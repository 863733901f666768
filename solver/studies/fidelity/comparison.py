"""How the histories of two runs compare: differences, sizes, and signals that are rounding."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...dynamics.analysis.recovery import extent
from ...inputs.case.record import KINDS, parts
from ...math.arrays import Array
from ...mechanism.built_mechanism import BuiltMechanism
from ...signals import Sensor, sensors
from ..tolerances import FAINT, FORCE_NOISE
from .plan import with_values

if TYPE_CHECKING:
    from ...inputs.case.tables.signals import Signal


def difference(metric: str, one: Array, two: Array) -> Array:
    """Return the difference (...) of histories.

    Parameters
    ----------
    metric : of `[fidelity]`: "pointwise", "extremum" or "rms"
    one, two : (..., k) values at k output times
    """
    if metric == "extremum":
        high = np.abs(one.max(axis=-1) - two.max(axis=-1))
        return np.asarray(np.maximum(high, np.abs(one.min(axis=-1) - two.min(axis=-1))))
    gap = np.asarray(one - two)
    if metric == "rms":
        return np.asarray(np.sqrt(np.mean(gap**2, axis=-1)))
    return np.asarray(np.abs(gap).max(axis=-1))


def scales(metric: str, values: Array) -> Array:
    """Return the largest value of signals (o, k), or their root mean square, (o,); 1 where zero."""
    sizes = np.sqrt(np.mean(values**2, axis=-1)) if metric == "rms" else np.abs(values).max(axis=-1)
    return np.where(sizes > 0.0, sizes, 1.0)


SILENT = 1e-12  # of the size of the mechanism: a length; of 1 rad: an angle
LENGTHS, ANGLES = ("position", "deflection"), ("orientation", "rotation")
# Of the largest relative. Packages are symmetric to rounding only: modes of a plane have 1e-10 of
# their size across it, and forces across the plane of planar pendulums 7e-10 of those in it.
SMALL = FAINT
RELATIVE = ": "  # between the name of a signal and that of its relative


@dataclass(frozen=True)
class Relatives:
    """What tells whether signals are rounding.

    Attributes
    ----------
    names : of the signals that are asked for
    table : these signals, what they are combined of, and their relatives
    least : size up to which each is rounding in any case
    factors : of relatives, by signal: their size times this is comparable
    """

    names: list[str]
    table: "dict[str, Signal]"
    least: dict[str, float]
    factors: dict[str, dict[str, float]]

    def sensors(self, built: BuiltMechanism) -> dict[str, Sensor]:
        """Return the sensors of all of them, those asked for first."""
        wanted = [*self.names, *(name for of in self.factors.values() for name in of)]
        markers = dict(built.signal_marker)  # a relative is one of the same place
        for name in set(wanted) - set(markers):
            if (place := name.partition(RELATIVE)[0]) in markers:
                markers[name] = markers[place]
        built = replace(built, signal_marker=markers)
        all_sensors = sensors(built, self.table, wanted=set(wanted))
        return {name: all_sensors[name] for name in dict.fromkeys(wanted)}

    def judged(
        self,
        signals: Mapping[str, Array],
        rtol: float = 0.0,
        quiet: npt.NDArray[np.bool_] | None = None,
    ) -> tuple[Array, Array]:
        """Return the signals asked for (o, k), with zeros for those that are rounding, and (o,)
        what those that are rounding or noise are compared with; 0: their own size.

        Parameters
        ----------
        rtol : of the run: its noise is of this size
        quiet : (o,) the signals that are rounding by the linear response; only these can be noise
        """
        values = np.array([signals[name] for name in self.names])
        sizes = np.zeros(len(values))
        for o, name in enumerate(self.names):
            near = max(
                (
                    f * float(np.abs(signals[n]).max(initial=0.0))
                    for n, f in self.factors[name].items()
                ),
                default=0.0,
            )
            whole = max(near, self.least[name] / SILENT)
            size = float(np.abs(values[o]).max(initial=0.0))
            if size < max(self.least[name], SMALL * near):
                values[o], sizes[o] = 0.0, whole
            elif quiet is not None and quiet[o] and size < FORCE_NOISE * rtol * whole:
                sizes[o] = whole
        return values, sizes


def relatives(names: list[str], mechanism: Any, built: BuiltMechanism, y0: Array) -> Relatives:
    """Return the relatives of signals of a mechanism in state y0 (n,), which gives its size.

    A strength ratio, infinite without stress, is compared by the exposure, its inverse.

    Parameters
    ----------
    names : of the signals
    mechanism : of the case, with all its signals
    built : the mechanism
    y0 : (n,) state that gives the size of the mechanism
    """
    size = extent(built.model, y0)
    table = {
        name: with_values(signal, kind="exposure") if signal.kind == "strength_ratio" else signal
        for name, signal in mechanism.signals.items()
    }
    least: dict[str, float] = {}
    factors: dict[str, dict[str, float]] = {}
    for name in names:
        least[name], factors[name] = 0.0, {}
        for part, by in _parts(name, table):
            signal = table[part]
            least[name] = max(least[name], SILENT * _size(signal, size) * by)
            if part != name and not _size(signal, size):
                factors[name][part] = by
            for key, other, factor in _others(signal, mechanism, size):
                table[part + RELATIVE + key] = other
                factors[name][part + RELATIVE + key] = factor * by
    return Relatives(list(names), table, least, factors)


def kind_of_signal(name: str, signals: Mapping[str, Any]) -> str:
    """Return the kind of a signal; of a combined one that of its first part."""
    return str(signals[[part for part, _ in _parts(name, signals)][-1]].kind)


def bends(name: str, signals: Mapping[str, Any]) -> bool:
    """Tell whether a signal follows from deformation alone, and has a bend where that is zero."""
    table = [signals[part] for part, _ in _parts(name, signals)]
    return all(s.kind in (*KINDS, "exposure", "deflection", "rotation") for s in table) and any(
        s.kind in ("exposure", "norm") or getattr(s, "component", "") == "magnitude" for s in table
    )


def _parts(name: str, signals: Mapping[str, Any], by: float = 1.0) -> Iterator[tuple[str, float]]:
    """Yield a signal and all that it is combined of, with the factors of their sizes in it."""
    signal = signals[name]
    yield name, by
    if signal.kind in KINDS:
        for part in reversed(parts(signal)):
            yield from _parts(part, signals, by / (signal.divide_by or 1.0))


def _size(signal: Any, size: float) -> float:
    """Return what a length or an angle is small against, in its own unit; 0: another quantity."""
    is_length = signal.kind in LENGTHS
    is_angle = signal.kind in ANGLES
    if signal.kind == "joint":
        is_angle = signal.coordinate.startswith("angle")
        is_length = not is_angle
    return (size * is_length + 1.0 * is_angle) / (signal.divide_by or 1.0)


FORCES, PLY = ("F1", "F2", "F3", "M1", "M2", "M3"), ("11", "22", "33", "23", "13", "12")
SPEEDS = ("velocity", "angular_velocity")


def _others(signal: Any, mechanism: Any, size: float) -> Iterator[tuple[str, Any, float]]:
    """Yield name, signal and factor of the relatives of a signal."""
    kind, whole = signal.kind, {"component": "magnitude"}
    changes: list[dict[str, str]] = []
    if kind == "acceleration" or (kind in ("deflection", "rotation") and signal.frame is None):
        changes = [whole]
    elif kind in SPEEDS:
        changes = [{"kind": other, **whole} for other in SPEEDS]
    elif kind == "reaction":
        joints = mechanism.joints.items()
        bodies = {
            n: {p.partition(".")[0] for p in joint.between} - {"ground"} for n, joint in joints
        }
        near = [name for name, of in bodies.items() if of & bodies[signal.joint]]
        quantities = ("force", "moment")
        changes = [{"joint": n, "quantity": q, **whole} for n in near for q in quantities]
    elif kind in ("resultant", "ply_stress"):
        changes = [{"component": each} for each in (FORCES if kind == "resultant" else PLY)]
    for values in changes:
        other = with_values(signal, **values)
        yield " of ".join(values.values()), other, size ** (_arm(signal) - _arm(other))


def _arm(signal: Any) -> int:
    """Return the power of a length in a quantity: moments over forces, speeds over rotations."""
    if signal.kind == "reaction":
        return int(signal.quantity == "moment")
    return int(signal.kind == "velocity" or (signal.kind == "resultant" and signal.component > "M"))
