"""Watch the energy balance from step to step."""

from dataclasses import dataclass, field

import numpy as np

from ...math.arrays import Array
from ...results.codes import ENERGY_JUMP, Finding
from ...results.schema import ROUNDING


@dataclass
class EnergyMonitor:
    """Energy less the work done on the system: constant, but for the error of the run.

    A single step that changes it visibly is no accumulated error but an event: an impact, a
    force with a jump, a step far too long.
    """

    in_play: float = 0.0  # largest energy, change of potential or work so far; least to begin [J]
    largest_jump: float = 0.0  # of the balance in one step [J]
    t_jump: float = 0.0
    balance: float = 0.0  # of the last state [J]
    _start: Array = field(default_factory=lambda: np.zeros(0))
    _terms: float = 0.0  # largest sum of the sizes of all energies and the work [J]

    def take(self, t: Array, energy: Array, work: Array) -> None:
        """Take the states after the last ones.

        Parameters
        ----------
        t, energy, work : (k,) [s], (k, 3) kinetic, strain, potential [J], (k,) done so far [J]
        """
        if t.size == 0:
            return
        balance = energy.sum(axis=1) - work
        if self._start.size == 0:
            self._start, self.balance = energy[0].copy(), float(balance[0])
        change = energy[:, 2] - self._start[2]
        sizes = (energy[:, 0].max(), energy[:, 1].max(), np.abs(change).max(), np.abs(work).max())
        self.in_play = float(max(self.in_play, *sizes))
        self._terms = max(self._terms, float((np.abs(energy).sum(axis=1) + np.abs(work)).max()))
        jumps = np.abs(np.diff(balance, prepend=self.balance))
        k = int(np.argmax(jumps))
        if jumps[k] > self.largest_jump:
            self.largest_jump, self.t_jump = float(jumps[k]), float(t[k])
        self.balance = float(balance[-1])

    def findings(self, *, sudden: bool = True) -> list[Finding]:
        """Return the largest jump of the run so far, if it is above the threshold.

        `sudden`: whether forces of the mechanism may jump, or bodies collide.
        """
        share = float(self.largest_jump / max(self.in_play, 1e-300))
        if share < ENERGY_JUMP.limit or self.largest_jump < ROUNDING * self._terms:
            return []
        cause = "the step was too long for the motion there: decrease rtol, or set max_step"
        if sudden:
            cause = "look for an impact or a jump of force there; decrease rtol"
        text = (
            f"one step, to t = {self.t_jump:.6g} s, changed the energy balance by "
            f"{share:.2g} of the energy in play (expected below {ENERGY_JUMP.limit:g}): {cause}"
        )
        return [ENERGY_JUMP.finding(text, t=self.t_jump, value=share)]
