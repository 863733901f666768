"""Constraints and energies over a run, a block of output times at a time."""

from dataclasses import dataclass, field

import numpy as np

from ..dynamics.recover import History
from ..math.arrays import Array
from ..results.schema import ENERGIES, ROUNDING

PEAKS = 200  # of the kinetic energy that are kept of a block of output times


@dataclass
class Largest:
    """The largest value so far, and its time."""

    value: float = 0.0
    t: float = 0.0  # [s]

    def take(self, t: Array, values: Array) -> None:
        """Take values (k,) at times t (k,)."""
        at = int(np.argmax(values))
        if values[at] > self.value or not np.isfinite(values[at]):
            self.value, self.t = float(values[at]), float(t[at])


@dataclass
class Past:
    """Largest violations and errors of the energy balance of a run."""

    position: Largest = field(default_factory=Largest)  # distance of connected points [m]
    rotation: Largest = field(default_factory=Largest)  # misalignment of connected axes [rad]
    velocity: Largest = field(default_factory=Largest)  # rate of the constraints [m/s, rad/s]
    balance: Largest = field(default_factory=Largest)  # change of the energy balance [J]
    drive_work: float = 0.0  # at the end [J]
    within: float = 0.0  # energy in play between these times, where it is known [J]
    kinetic: list[tuple[float, float]] = field(default_factory=list)  # times, peaks up to them [J]
    _start: float | None = None
    _scale: float = 0.0
    _terms: dict[str, float] = field(default_factory=dict)  # largest of each energy [J]
    _lowest: float = np.inf
    _highest: float = -np.inf

    def take(self, t: Array, history: History) -> None:
        """Take the history at times t (k,) after the last ones."""
        self.position.take(t, history.position_violation)
        self.rotation.take(t, history.rotation_violation)
        self.velocity.take(t, history.velocity_violation)
        e = history.energies
        balance = e["kinetic"] + e["strain"] + e["potential"] - e["drive_work"]
        if self._start is None:
            self._start = float(balance[0])
        self.balance.take(t, np.abs(balance - self._start))
        for part in np.array_split(np.arange(t.size), min(t.size, PEAKS)):
            self.kinetic.append((float(t[part[-1]]), float(e["kinetic"][part].max())))
        sizes = np.abs(e["kinetic"]).max(), np.abs(e["drive_work"]).max()
        self._scale = float(max(self._scale, *sizes))
        for name in ENERGIES:
            self._terms[name] = max(self._terms.get(name, 0.0), float(np.abs(e[name]).max()))
        self._lowest = float(min(self._lowest, e["potential"].min()))
        self._highest = float(max(self._highest, e["potential"].max()))
        self.drive_work = float(e["drive_work"][-1])

    @property
    def energy_in_play(self) -> float:
        """Largest energy of the run [J]; see results.energy_in_play."""
        return max(self._scale, self.within, self._highest - self._lowest) or 1.0

    @property
    def energy_drift(self) -> float:
        """Largest error of the energy balance over the largest energy in play; see
        results.relative_balance."""
        rounding = ROUNDING * sum(self._terms.values())
        return self.balance.value / self.energy_in_play if self.balance.value > rounding else 0.0
