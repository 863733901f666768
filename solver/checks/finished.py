"""A finished run as the checks see it."""

from collections.abc import Callable, Mapping
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
from ..mechanism import BuiltMechanism
from ..package import ModalPackage
from ..results import energy_in_play, relative_balance
from ..results.finding import Finding

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


@dataclass(frozen=True)
class FinishedRun:
    """Everything that the checks judge a run by.

    Attributes
    ----------
    mechanism : what was built
    order : of the integrator; 0 if it took no step
    noticed : findings of preparation and monitors
    """

    mechanism: "Mechanism"
    built: BuiltMechanism
    treatment: Treatment
    solution: Solution
    order: int = 0
    noticed: tuple[Finding, ...] = ()
    look: Look = field(default_factory=Look)

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
        count = self.solution.t.size
        if most is None or count <= most:
            return np.arange(count)
        return np.unique(np.linspace(0, count - 1, most).astype(int))

    def at(self, most: int | None) -> tuple[Array, Array]:
        """Return at most so many output times (k,) and their states (k, n)."""
        rows = self.some(most)
        return self.solution.t[rows], self.solution.y[rows]

    def scan(self, values: Callable[[Array, Array], Array], most: int) -> tuple[Array, Array]:
        """Return times (k,) [s] and values (k,) of a quantity whose highest value matters.

        `values` of times (k,) and states (k, n) are looked at for at most so many output times, and
        then for those around the highest of them.
        """
        t, y, rows = self.solution.t, self.solution.y, self.some(most)
        found = values(t[rows], y[rows])
        top = int(np.argmax(found))
        around = np.arange(rows[max(top - 1, 0)], rows[min(top + 1, rows.size - 1)])
        more = np.setdiff1d(around, rows)
        if more.size:
            found = np.concatenate([found, values(t[more], y[more])])
        seen = np.concatenate([rows, more])
        order = np.argsort(seen)
        return t[seen[order]], found[order]

    @cached_property
    def past(self) -> recover.History:
        """Multipliers, energies and violations at the times of `look.balance`."""
        return recover.history(self.model, *self.at(self.look.balance))

    @cached_property
    def balance(self) -> Array:
        """Relative error of the energy balance at the times of `look.balance`."""
        return relative_balance(self.past.energies)

    @cached_property
    def energy_in_play(self) -> float:
        """Largest energy of the run [J]."""
        return energy_in_play(self.past.energies)

    @cached_property
    def momentum_balance(self) -> float:
        """Relative error of loads and reactions against the change of momentum."""
        found = momentum_balance(self.model, *self.at(self.look.momentum))
        return max(found.linear, found.angular)

    @cached_property
    def degrees_of_freedom(self) -> int:
        """Degrees of freedom at the start."""
        return degrees_of_freedom(self.model, self.solution.y[0])

    def modes(self, body: int) -> Array:
        """Modal coordinates (k, m) of a body at all output times."""
        a = int(self.model.pos_start[body]) + 7
        return self.solution.y[:, a : a + int(self.model.n_mode[body])]

    def numbers(self) -> dict[str, float | int]:
        """Return what summary.json and sweep.h5 keep of the checks."""
        damped = self.solution.damped_energy
        return {
            "constraint_position_max": float(self.past.position_violation.max()),
            "constraint_rotation_max": float(self.past.rotation_violation.max()),
            "constraint_velocity_max": float(self.past.velocity_violation.max()),
            "energy_drift_relative": float(np.abs(self.balance).max()),
            "drive_work": float(self.past.energies["drive_work"][-1]) + damped,
            "damped_energy": damped,
            "momentum_balance": self.momentum_balance,
            "degrees_of_freedom": self.degrees_of_freedom,
        }
