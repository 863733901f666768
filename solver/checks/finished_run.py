"""A finished run as the checks see it."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..dynamics.analysis import recovery as recover
from ..dynamics.analysis.rank import degrees_of_freedom
from ..dynamics.analysis.recovery import History, momentum_balance
from ..dynamics.elements.constraints.treatment import Treatment
from ..dynamics.model.model import Model
from ..integrators.generic.drive import Solution, Steps
from ..math.arrays import Array, IntArray, distinct
from ..math.records import record
from ..math.rows import spans
from ..mechanism.built_mechanism import BuiltMechanism
from ..package import ModalPackage
from ..results.codes import Finding
from ..results.run_result import ENERGIES, ROUNDING

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism

PEAKS = 200  # of the kinetic energy that are kept of a block of output times


LEAST, MOST = -200, 200  # exponents of two


@dataclass(eq=False, repr=False)
class StepSizes:
    """How many steps of each size a run has taken."""

    _count: Array = field(default_factory=lambda: np.zeros(MOST - LEAST + 1))
    _time: Array = field(default_factory=lambda: np.zeros(MOST - LEAST + 1))  # [s]

    def take(self, steps: Steps) -> None:
        """Take the steps after the last ones."""
        h = np.diff(steps.t)
        h = h[h > 0.0]
        place = np.clip(np.frexp(h)[1], LEAST, MOST) - LEAST
        np.add.at(self._count, place, 1.0)
        np.add.at(self._time, place, h)

    def steps_with(self, max_step: float) -> float:
        """Return about how many steps the run would take with no step above `max_step` [s]."""
        return float(np.maximum(self._count, self._time / max_step).sum())


@dataclass(eq=False, repr=False)
class Largest:
    """The largest value so far, and its time."""

    value: float = 0.0
    t: float = 0.0  # [s]

    def take(self, t: Array, values: Array) -> None:
        """Take values (k,) at times t (k,)."""
        at = int(np.argmax(values))
        if values[at] > self.value or not np.isfinite(values[at]):
            self.value, self.t = float(values[at]), float(t[at])


@dataclass(eq=False, repr=False)
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


class Look(NamedTuple):
    """Number of output times, at most, that each check looks at; None: all.

    A sweep looks at fewer, never with fewer checks. The search for the worst instant of stiffening
    goes on between the neighbours of the worst one of these.
    """

    balance: int | None = None  # constraints and energies
    momentum: int = 101
    stiffening: int = 401
    strength: int | None = None


@record
class FinishedRun:
    """Everything that the checks judge a run by.

    Attributes
    ----------
    mechanism : what was built
    order : of the integrator; 0 if it took no step
    noticed : findings of preparation and monitors
    independent : whether no constraint depends on others at the start; False: not known
    """

    mechanism: "Mechanism"
    built: BuiltMechanism
    treatment: Treatment
    solution: Solution
    order: int = 0
    noticed: tuple[Finding, ...] = ()
    look: Look = field(default_factory=Look)
    known: Past | None = None  # `past`, of who has computed it
    independent: bool = False
    in_play: float = 0.0  # energy in play at any step; output times may show less [J]
    sizes: StepSizes = field(default_factory=StepSizes)

    @property
    def model(self) -> Model:
        """The model, prepared for its treatment of constraints."""
        return self.built.model

    @property
    def packages(self) -> Mapping[str, ModalPackage]:
        """Packages of the flexible bodies, by name."""
        return self.built.packages

    def better_frame(self, name: str) -> str:
        """Return advice on the frame of a body; empty where no other keeps rotations smaller."""
        clamped = self.packages[name].reference_condition == "clamped"
        return "use a chord or mean-axis frame, or " if clamped else ""

    def some(self, most: int | None) -> IntArray:
        """Return rows of at most so many output times, first and last included."""
        return self._spread(self.solution.t.size, most)

    @staticmethod
    def _spread(count: int, most: int | None) -> IntArray:
        if most is None or count <= most:
            return np.arange(count)
        return distinct(np.linspace(0, count - 1, most).astype(int))

    def at(self, most: int | None) -> tuple[Array, Array]:
        """Return at most so many output times (k,) and their states (k, n)."""
        rows = self.some(most)
        return self.solution.t[rows], self.solution.y[rows]

    def scan(self, values: Callable[[Array, Array], Array], most: int) -> tuple[Array, Array]:
        """Return times (k,) [s] and values (k,) of a quantity whose highest value matters.

        `values` of times (k,) and states (k, n) are looked at for at most so many output times,
        then for as many around the highest of them, until there are none between.
        """
        t, y, seen = self.solution.t, self.solution.y, self.some(most)
        sampled = values(t[seen], y[seen])
        while True:
            top = int(np.argmax(sampled))
            around = np.arange(seen[max(top - 1, 0)], seen[min(top + 1, seen.size - 1)])
            more = np.setdiff1d(around, seen, assume_unique=True)
            if not more.size:
                return t[seen], sampled
            more = more[self._spread(more.size, most)]
            seen, sampled = np.append(seen, more), np.append(sampled, values(t[more], y[more]))
            order = np.argsort(seen)
            seen, sampled = seen[order], sampled[order]

    def blocks(self, most: int | None = None) -> Iterator[tuple[Array, Array]]:
        """Yield times (k,) and states (k, n), of at most so many output times, block by block."""
        t, y = self.solution.t, self.solution.y
        if most is not None and most < t.size:
            t, y = self.at(most)
        for first, end in spans(t.size, y.shape[1]):
            yield t[first:end], y[first:end]

    @cached_property
    def past(self) -> Past:
        """Violations and energies at the times of `look.balance`."""
        if self.known is not None:
            return self.known
        past = Past(within=self.in_play)
        for t, y in self.blocks(self.look.balance):
            past.take(t, recover.history(self.model, t, y))
        return past

    @cached_property
    def momentum_balance(self) -> float:
        """Relative error of loads and reactions against the change of momentum."""
        balance = momentum_balance(self.model, *self.at(self.look.momentum))
        return max(balance.linear, balance.angular)

    @cached_property
    def degrees_of_freedom(self) -> int:
        """Degrees of freedom at the start."""
        return degrees_of_freedom(self.model, self.solution.y[0], independent=self.independent)

    def modes(self, body: int, most: int | None = None) -> Iterator[tuple[Array, Array]]:
        """Yield times (k,) and modal coordinates (k, m) of a body; see `blocks`."""
        a = int(self.model.pos_start[body]) + 7
        for t, y in self.blocks(most):
            yield t, y[:, a : a + int(self.model.n_mode[body])]

    def numbers(self) -> dict[str, float | int]:
        """Return what summary.json and sweep.h5 keep of the checks."""
        damped = self.solution.damped_energy
        return {
            "constraint_position_max": self.past.position.value,
            "constraint_rotation_max": self.past.rotation.value,
            "constraint_velocity_max": self.past.velocity.value,
            "energy_drift_relative": self.past.energy_drift,
            "drive_work": self.past.drive_work + damped,
            "damped_energy": damped,
            "momentum_balance": self.momentum_balance,
            "degrees_of_freedom": self.degrees_of_freedom,
        }
