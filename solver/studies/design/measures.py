"""What a study reads of a design: arrays of a run or package, and numbers made of them.

A measure first takes an array `raw` (..., k) whose entries depend smoothly on the design: a signal
at the output times, the eigenvalues of a body, a 6x6 stiffness. `reduce` makes r values of it, with
their derivatives by the entries. The derivative of a value by a parameter is then their product
with the derivative of the array, wherever that comes from.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...checks.finished_run import FinishedRun
from ...dynamics.analysis.recovery import Recording
from ...errors import InputError
from ...inputs.case.bodies.segments import segment_name
from ...inputs.case.tables.bodies import RigidBody
from ...inputs.case.tables.design_keys import MECHANISM, Quantity
from ...inputs.case.tables.signals import StrengthSignal
from ...math.arrays import Array
from ...package import ModalPackage
from ...package.body.selection import vibrations
from ...run.inputs import RunSpec
from ...signals import Sensor
from ...signals.strength import strength_values
from ..tolerances import NO_COUPLING

MOST_PEAKS = 8  # local peaks of a measure, the highest first, which are constraints of their own
SHARPNESS = 200.0  # of the lowest of several eigenvalues: 0.17 % of a frequency for two equal ones


@dataclass(frozen=True)
class Made:
    """A design that was built and, if anything needs it, run."""

    spec: RunSpec
    finished: FinishedRun | None
    sensors: Mapping[str, Sensor]
    recording: Recording | None

    @property
    def t(self) -> Array:
        """Output times (n_t,) [s]; none without a run."""
        return np.zeros(0) if self.finished is None else self.finished.solution.t

    def parts(self, name: str) -> list[ModalPackage]:
        """Return the packages of a body, or of all; those of its segments."""
        packages = self.spec.packages
        if name in (MECHANISM, *packages):
            return list(packages.values()) if name == MECHANISM else [packages[name]]
        first = segment_name(name, 0)[:-1]
        return [p for n, p in packages.items() if n.startswith(first)]

    def series(self) -> tuple[FinishedRun, Recording]:
        """Return run and recording of a design whose measures need them."""
        assert self.finished is not None
        assert self.recording is not None
        return self.finished, self.recording


class Measure:
    """A number r = 1 of an array of one entry; base of all others.

    Attributes
    ----------
    quantity : what the user asks for
    runs : whether the mechanism must be integrated
    peaks : 1: the values are local maxima, of which the largest counts; -1: minima; 0: one value
    unit : of `shown`
    """

    runs = False
    peaks = 0
    unit = ""

    def __init__(self, quantity: Quantity) -> None:
        self.quantity = quantity

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return the array of a design; with weights (r, ...), zeros may replace what has none."""
        raise NotImplementedError

    def reduce(self, raw: Array, t: Array) -> tuple[Array, Array]:
        """Return values (r,) and their derivatives by the array (r, *raw.shape)."""
        return raw.copy(), np.eye(1)

    def shown(self, raw: Array, t: Array) -> float:
        """Return the number that a user reads."""
        values = self.reduce(raw, t)[0]
        return float(values.min() if self.peaks < 0 else values.max())


class Mass(Measure):
    """Mass of a body or of the mechanism [kg]."""

    unit = "kg"

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return the mass (1,)."""
        name, mechanism = self.quantity.name, made.spec.mechanism
        mass = sum(float(p.invariants.mass) for p in made.parts(name))
        for body, table in mechanism.bodies.items():
            if isinstance(table, RigidBody) and name in (MECHANISM, body):
                mass += table.mass
        if name == MECHANISM:
            mass += sum(point.mass for point in mechanism.masses.values())
        return np.array([mass])


class SectionEntry(Measure):
    """Entry of stiffness or flexibility of the first section of a beam."""

    def __init__(self, quantity: Quantity) -> None:
        super().__init__(quantity)
        name = str(quantity.entry)
        unit = ("N", "N m", "N m2")[(name[1] > "3") + (name[2] > "3")]
        self.unit = unit if name[0] == "K" else f"1/({unit})"

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return the 6x6 stiffness."""
        sections = made.parts(self.quantity.name)[0].sections
        if not sections:
            raise InputError(f"section = {self.quantity.name!r}: the package has no section")
        return np.asarray(sections[0].K)

    def reduce(self, raw: Array, t: Array) -> tuple[Array, Array]:
        """d(K^-1)_ij = -K^-1 dK K^-1. Rounding of an entry is zero; its derivative may not be."""
        name, matrix, weights = str(self.quantity.entry), raw, np.zeros((6, 6))
        i, j = int(name[1]) - 1, int(name[2]) - 1
        weights[i, j] = 1.0
        if name[0] == "S":
            matrix = np.asarray(np.linalg.inv(raw))
            weights = -np.outer(matrix[i], matrix[:, j])
        couples = abs(matrix[i, j]) > NO_COUPLING * np.sqrt(matrix[i, i] * matrix[j, j])
        return couples * matrix[[i], [j]], weights[None]


class Frequency(Measure):
    """Lowest natural frequency of a body, or of the mechanism about its start [Hz].

    Values are a smooth lower bound of the lowest of all eigenvalues, (sum w^-2p)^(-1/p), which is
    symmetric in them: it has a derivative where frequencies meet, by the trace over the cluster.
    """

    unit = "Hz"

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return squares of natural circular frequencies (m,) [rad2/s2]."""
        if self.quantity.name == MECHANISM:
            from ..modes.place import At
            from ..modes.state import States
            from ..modes.state_modes import find_modes  # most studies need no linearised equations

            states = States(made.spec)
            w = find_modes(states, states.at(At("start"), None), ports=False, check=False).modes
            squares = np.abs(w.eigenvalues[w.frequencies > 0.0]) ** 2
        else:
            package = made.parts(self.quantity.name)[0]
            squares = package.frequencies[vibrations(package)] ** 2
        if not squares.size:
            raise InputError(f"frequency = {self.quantity.name!r}: there is no vibration mode")
        return np.sort(squares)

    def reduce(self, raw: Array, t: Array) -> tuple[Array, Array]:
        """Return the smooth lowest frequency (1,) and weights (1, m)."""
        share = (raw / raw[0]) ** -SHARPNESS
        lowest = raw[0] * share.sum() ** (-1.0 / SHARPNESS)
        f = np.sqrt(lowest) / (2.0 * np.pi)
        weights = 0.5 * f / raw * share / share.sum()
        return np.array([f]), weights[None]

    def shown(self, raw: Array, t: Array) -> float:
        """Return the lowest frequency itself."""
        return float(np.sqrt(raw[0]) / (2.0 * np.pi))


class OverTime(Measure):
    """A signal: its local peaks, its root mean square or its value at a time."""

    runs = True

    def __init__(self, quantity: Quantity) -> None:
        super().__init__(quantity)
        self.peaks = {"max": 1, "min": -1}.get(str(quantity.of), 0)

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return the signal (n_t,)."""
        sensor = made.sensors[self.quantity.name]
        self.unit = sensor.unit
        return sensor.values(made.series()[1])

    def reduce(self, raw: Array, t: Array) -> tuple[Array, Array]:
        """Return values (r,) and weights (r, n_t)."""
        span = _span(self.quantity, t)
        if self.quantity.of == "at":
            time = float(self.quantity.time or 0.0)
            weights = np.array([np.interp(time, t, row) for row in np.eye(t.size)])
        elif self.quantity.of == "rms":
            w = np.zeros(t.size)
            w[span] = np.gradient(t[span])
            w[span[[0, -1]]] *= 0.5
            w /= w.sum()
            value = np.sqrt((w * raw**2).sum())
            weights = w * raw / value if value else np.zeros(t.size)
        else:
            values, table = peaks(raw[None], t, span, self.peaks)
            return values, table[:, 0]
        return np.array([weights @ raw]), weights[None]


class DeformationEnergy(OverTime):
    """Elastic energy of the modes of a body, or of all flexible bodies [J]."""

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return the energy (n_t,)."""
        finished, recording = made.series()
        self.unit, total = "J", np.zeros(made.t.size)
        for i, body in enumerate(finished.built.body_names):
            package = finished.built.packages.get(body)
            if package is not None and self.quantity.name in (MECHANISM, body):
                q = recording.modes(i)
                total += 0.5 * np.einsum("ti,ij,tj->t", q, package.stiffness, q)
        return total


class Strength(Measure):
    """Exposures 1 / R of every ply of a body over time; the local peaks of each count."""

    runs, peaks = True, 1

    def raw(self, made: Made, weights: Array | None = None) -> Array:
        """Return exposures (plies, n_t)."""
        finished, recording = made.series()
        name = self.quantity.name
        body, package = finished.built.body_names.index(name), finished.built.packages[name]
        plies, known = _plies(package), weights is not None
        rows = np.zeros((len(plies), made.t.size))  # zero of a ply without strengths
        read = range(len(plies))
        for row in read if weights is None else np.flatnonzero(weights.any(axis=(0, 2))):
            region, ply = plies[row]
            table = {"kind": "exposure", "body": name, "region": region, "ply": ply}
            with suppress(InputError):  # a ply without strengths
                signal = StrengthSignal.model_validate(table)
                values = strength_values(f"{name}, {region}, ply {ply}", body, package, signal)
                rows[row], known = values(recording), True
        if not known:
            raise InputError(f"strength = {name!r}: no material of the body has strengths")
        return rows

    def reduce(self, raw: Array, t: Array) -> tuple[Array, Array]:
        """Return the highest peaks (r,) and weights (r, plies, n_t)."""
        return peaks(raw, t, np.arange(t.size), 1)

    def shown(self, raw: Array, t: Array) -> float:
        """Return the lowest strength ratio."""
        highest = float(raw.max())
        return 1.0 / highest if highest else np.inf


def _plies(package: ModalPackage) -> list[tuple[str, int]]:
    """Return region and number of the plies of a body, each once."""
    plies = [
        (ply.region, ply.index)
        for section in package.sections
        if section.recovery is not None
        for ply in section.recovery.plies
    ]
    plies += [(each.name, k) for each in package.laminates for k in range(len(each.plies))]
    return list(dict.fromkeys(plies))


def _span(quantity: Quantity, t: Array) -> Any:
    """Return the output times between `from` and `to`, as rows."""
    low = -np.inf if quantity.low is None else quantity.low
    high = np.inf if quantity.high is None else quantity.high
    near = 1e-9 * float(t[-1])
    samples = np.flatnonzero((t >= low - near) & (t <= high + near))
    if samples.size < 3:
        raise InputError(
            f"{quantity.words()}: from, to: expected three output times between them or more"
        )
    return samples


def peaks(rows: Array, t: Array, span: Any, sign: int) -> tuple[Array, Array]:
    """Return the highest local maxima of series and their weights.

    A maximum is that of the parabola through the largest output and its neighbours. Its place in
    time does not matter to first order, so the derivative of its value is that of the series there.

    Parameters
    ----------
    rows : (s, n_t) series
    span : (k,) the output times that count
    sign : -1 for minima

    Returns
    -------
    (MOST_PEAKS,) values, the highest first, the last one repeated; (MOST_PEAKS, s, n_t) weights
    """
    candidates: list[tuple[float, int, dict[int, float]]] = []
    for k, row in enumerate(rows):
        y = sign * row[span]
        up = np.r_[True, y[1:] > y[:-1]]
        down = np.r_[y[:-1] >= y[1:], True]
        for i in np.flatnonzero(up & down).tolist():
            weights = {int(span[i]): 1.0}
            if 0 < i < y.size - 1:
                weights = _parabola(t, int(span[i]), sign * row)
            candidates.append((sum(w * float(row[j]) for j, w in weights.items()), k, weights))
    candidates.sort(key=lambda each: -sign * each[0])
    candidates = (candidates + [candidates[-1]] * MOST_PEAKS)[:MOST_PEAKS]
    table = np.zeros((MOST_PEAKS, *rows.shape))
    for n, (_, k, weights) in enumerate(candidates):
        for j, w in weights.items():
            table[n, k, j] = w
    return np.array([value for value, _, _ in candidates]), table


def _parabola(t: Array, i: int, y: Array) -> dict[int, float]:
    """Return the weights of three outputs at the top of the parabola through them."""
    a, b = t[i - 1] - t[i], t[i + 1] - t[i]
    left, right = (y[i - 1] - y[i]) / a, (y[i + 1] - y[i]) / b
    bent = (right - left) / (b - a)
    top = float(np.clip((bent * a - left) / (2.0 * bent) if bent < 0.0 else 0.0, a, b))
    own = (top - a) * (top - b) / (a * b)
    return {
        i - 1: top * (top - b) / (a * (a - b)),
        i: own,
        i + 1: top * (top - a) / (b * (b - a)),
    }


KINDS = {
    "signal": OverTime,
    "strength": Strength,
    "frequency": Frequency,
    "mass": Mass,
    "section": SectionEntry,
    "deformation_energy": DeformationEnergy,
}


def measure_of(quantity: Quantity) -> Measure:
    """Return the measure of a quantity."""
    return KINDS[quantity.subject](quantity)
