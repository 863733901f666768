"""Radau IIA of order 5 for mechanisms: its options, its answer to a stall, its dense output."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..dynamics.model import Model
from ..dynamics.scales import scales
from ..dynamics.series import driven_speeds
from ..math.arrays import Array
from ..math.keys import Number
from .compiled import step_control as codes
from .compiled.dependent_rows import PENALTY
from .compiled.radau import advance
from .compiled.radau_workspace import new_radau_workspace, restart_radau
from .compiled.step_control import Ends
from .compiled.tableau import MU
from .generic.advice import SHORTER, WANTED
from .generic.base import Dense
from .generic.explicit import Powers
from .generic.pace import OWN, Pace, Refusals
from .ringing import kinetic_energies, ringing
from .step_loop import ClosingLoop
from .turning import A_TURN, GROWN, TOO_FAST, Turning, turning

# Cutoffs that are tried against a stall, times pi over the interval of the results.
CUTOFFS = (10.0, 3.0, 1.0)
TURNS_TOO_FAST = (
    "The motion has grown beyond all measure: at t = {t:.6g} s a body turns at {spin:.2g} rad/s, "
    "its mass at {rim:.2g} m/s, which no material holds, and the steps are those of its rotation. "
    "Look for a feedback that is unstable, or for loads in other units."
)

PATIENCE = 4  # looks at a run that goes on stalled, before the next
# Part of the kinetic energy above a cutoff: with more than half, the motion itself would be damped.
MOTION = 0.5
NOTHING = 1e-20  # part of it that is rounding: no vibration is above the cutoff


class Radau(ClosingLoop):
    """Radau IIA of order 5 for mechanisms (compiled/radau.py): L-stable, so that modes stiffer than
    the motion are damped, not followed; every step is brought back onto the constraints unless
    `closed` is false.
    """

    name = "radau"
    samples = True
    local_share = 0.5
    meaning = "implicit Runge-Kutta of order 5, the fastest where modes are stiff"
    place = 2
    order = 5
    on_growth = (
        "Newton's iteration finds no answer for a step this long, or constraints contradict each "
        f"other: take a shorter step ({SHORTER})"
    )
    on_failure = (
        "Look for a jump or a singularity in the forces just after it, or for constraints that "
        "contradict each other, or increase rtol"
    )

    on_stall = (
        "cutoff_frequency, above which vibrations are damped; damping of the body or element; "
        f"fewer modes; or rtol and atol_velocity that do not ask for the vibration. {WANTED}"
    )
    keys = (
        Number(
            "cutoff_frequency",
            "rad/s",
            "of radau: faster vibrations are damped, not resolved; 0: all are resolved that the "
            "tolerance asks for; default: as 0, until they stall the run (integrators.md)",
            least=0,
        ),
    )

    def __init__(
        self,
        model: Model,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        cutoff_frequency: float | None = None,
        **options: Any,
    ) -> None:
        super().__init__(model, t0, y0, t_end, **options)
        self._workspace.clock[codes.CUTOFF] = cutoff_frequency or 0.0
        self._tries = list(CUTOFFS) if cutoff_frequency is None else []
        self._patience = 0
        self._y_start = y0
        self._kinetic = np.zeros(2)  # largest at these looks, above the cutoff and of all [J]

    def follow(self, pace: Pace) -> None:
        """Answer a stall by a cutoff, as high as ends it; end a run that turns beyond all measure.

        Short steps of a body that turns fast are those of its rotation: no cutoff changes them.
        Neither does one help rigid bodies, whose motion is no vibration; and a vibration with
        most of the kinetic energy is the motion itself, which no cutoff may damp.
        """
        found = pace.stalled(self.t, self.counters.steps, self.counters.rejected)
        if found is None:
            return
        fastest = turning(self._model, self.y)
        if fastest.spin * found.step > A_TURN:
            if fastest.rim > TOO_FAST and self._is_beyond(fastest):
                self.status = "failed"
                self.message = TURNS_TOO_FAST.format(t=self.t, spin=fastest.spin, rim=fastest.rim)
            return
        cutoff = (self._tries or CUTOFFS)[0] * np.pi / pace.interval
        least = self._workspace.cutoff.held.stiffness
        energies = kinetic_energies(self._model, least, self.t, self.y, cutoff)
        self._kinetic = np.maximum(self._kinetic, energies)
        component, rate = ringing(self._model, self._workspace)
        if energies[0] <= NOTHING * energies[1] and rate * found.step > OWN:
            return
        if not self.stalls:
            self.stalls = [replace(found, component=component, rate=rate, remedy=self.on_stall)]
        elif self._patience > 0:
            self._patience -= 1
            return
        if self._tries and self._kinetic[0] <= MOTION * self._kinetic[1]:
            self._tries.pop(0)
            self._patience = PATIENCE
            self._workspace.clock[codes.CUTOFF] = cutoff
            self.stalls = [replace(self.stalls[0], cutoff=cutoff)]

    def _is_beyond(self, fastest: Turning) -> bool:
        """Tell whether the body turns far faster than the start and the drives prescribe."""
        model = self._model
        prescribed = np.abs(driven_speeds(model, np.array([self.t]), self.y)).max(initial=0.0)
        speed = scales(model, self._y_start, self.t_end).speed
        return bool(fastest.spin > GROWN * prescribed and fastest.rim > GROWN * speed)

    def refusals(self) -> Refusals:
        """Attempts that were refused so far, with the component that was most often the reason."""
        blamed = self._workspace.blamed
        component = int(np.argmax(blamed)) if blamed.any() else -1
        return replace(super().refusals(), component=component)

    @property
    def damped_energy(self) -> float:
        """Energy taken out of vibrations above the cutoff [J]."""
        return float(self._workspace.damped.sum())

    def for_loop(self, model: Model) -> Model:
        """Return the model with the softness of dependent rows that suits the iteration."""
        return model._replace(penalty=PENALTY) if model.penalty > 0.0 else model

    def _begin(self, rate: Array, multipliers: Array) -> Any:
        return new_radau_workspace(self._model, self.t, self.y, rate, multipliers, self._h_next)

    def _restart(self, rate: Array, multipliers: Array) -> None:
        restart_radau(self._model, self._workspace, self.t, self.y, rate, multipliers)

    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        return advance(self._model, self._options, self._workspace, most, times, rows, filled, ends)

    def _dense(self) -> Dense:
        workspace, h = self._workspace, self.h
        polynomial = Powers(self.t_old, h, workspace.y_old.copy(), workspace.Q.copy())
        return self._closed_inside(polynomial, MU / h) if self._closed else polynomial
