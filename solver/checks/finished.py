"""A finished run as the checks see it."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics import recover
from ..dynamics.constraints.treatment import Treatment
from ..dynamics.freedom import degrees_of_freedom
from ..dynamics.model import Model
from ..dynamics.reactions import momentum_balance
from ..integrators.generic import Solution
from ..math.arrays import Array, IntArray
from ..math.rows import spans
from ..mechanism import BuiltMechanism
from ..monitors.step_sizes import StepSizes
from ..package import ModalPackage
from ..results.finding import Finding
from .past import Past

if TYPE_CHECKING:
    from ..inputs.case.schema import Mechanism


@dataclass(frozen=True)
class Look:
    """Number of output times, at most, that each check looks at; None: all.

    A sweep looks at fewer, never with fewer checks. The search for the worst instant of stiffening
    goes on between the neighbours of the worst one of these.
    """

    balance: int | None = None  # constraints and energies
    momentum: int = 101
    stiffening: int = 401
    strength: int | None = None


ROUNDING = 1e-6  # of the loads: resultants below it are not judged


@dataclass(frozen=True)
class Missing:
    """What the modes miss.

    Attributes
    ----------
    share : of the strain energy under the loads of the run, mean over time; of a load at one place
        also the share of the deflection there
    t : instant at which most is missing [s]
    parts : (6,) shares by resultant, which add up to `share`
    row, x : moment, or axial force, of which most is missing then, and where [m]
    carried, whole : what the modes have of it, and what it is [N m, N]
    loads_B : forces and moments at interfaces then, by name, (6,)
    """

    share: float
    t: float
    parts: Array
    row: int
    x: float
    carried: float
    whole: float
    loads_B: dict[str, Array]


@dataclass(frozen=True)
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
    missing: "Callable[[FinishedRun], Callable[[int], Missing | None]] | None" = None  # run/missing

    @property
    def model(self) -> Model:
        """The model, prepared for its treatment of constraints."""
        return self.built.model

    @property
    def packages(self) -> Mapping[str, ModalPackage]:
        """Packages of the flexible bodies, by name."""
        return self.built.packages

    def some(self, most: int | None) -> IntArray:
        """Return rows of at most so many output times, first and last included."""
        return self._spread(self.solution.t.size, most)

    @staticmethod
    def _spread(count: int, most: int | None) -> IntArray:
        if most is None or count <= most:
            return np.arange(count)
        return np.unique(np.linspace(0, count - 1, most).astype(int))

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
        found = values(t[seen], y[seen])
        while True:
            top = int(np.argmax(found))
            around = np.arange(seen[max(top - 1, 0)], seen[min(top + 1, seen.size - 1)])
            more = np.setdiff1d(around, seen)
            if not more.size:
                return t[seen], found
            more = more[self._spread(more.size, most)]
            seen, found = np.append(seen, more), np.append(found, values(t[more], y[more]))
            order = np.argsort(seen)
            seen, found = seen[order], found[order]

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
        found = momentum_balance(self.model, *self.at(self.look.momentum))
        return max(found.linear, found.angular)

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
