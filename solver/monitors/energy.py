"""Watch the energy balance from step to step."""

from dataclasses import dataclass, field

import numpy as np

from ..dynamics.model import Model
from ..dynamics.system import Equations, energies
from ..math.arrays import Array
from ..results.codes.motion import ENERGY_JUMP
from ..results.finding import Finding


@dataclass
class EnergyMonitor:
    """Energy less the work done on the system: constant, but for the error of the run.

    A single step that changes it visibly is no accumulated error but an event: an impact, a
    force with a jump, a step far too long.
    """

    model: Model
    in_play: float = 0.0  # largest energy, change of potential or work so far [J]
    largest_jump: float = 0.0  # of the balance in one step [J]
    t_jump: float = 0.0
    _start: Array = field(default_factory=lambda: np.zeros(0))
    _balance: float = 0.0

    def take(self, t: float, equations: Equations, y: Array) -> float:
        """Take the state of the next step, and return the balance there [J]."""
        energy = energies(self.model, equations, y)
        balance = float(energy.sum() - y[-1])
        first = self._start.size == 0
        if first:
            self._start = energy
        self.in_play = max(
            self.in_play, energy[0], energy[1], abs(energy[2] - self._start[2]), abs(y[-1])
        )
        jump = abs(balance - self._balance)
        if not first and jump > self.largest_jump:
            self.largest_jump, self.t_jump = jump, float(t)
        self._balance = balance
        return balance

    def findings(self) -> list[Finding]:
        """Return the largest jump of the run so far, if it is above the threshold."""
        share = float(self.largest_jump / max(self.in_play, 1e-300))
        if share < ENERGY_JUMP.limit:
            return []
        text = (
            f"one step, to t = {self.t_jump:.6g} s, changed the energy balance by "
            f"{share:.2g} of the energy in play (expected below {ENERGY_JUMP.limit:g}): look for "
            "an impact or a jump of force there; tighten rtol and atol"
        )
        return [ENERGY_JUMP.finding(text, t=self.t_jump, value=share)]
