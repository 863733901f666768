"""Radau IIA of order 5 for mechanisms: its options, its answer to a stall, its dense output."""

from typing import Any, NamedTuple

import numpy as np

from ..dynamics.analysis.recovery import scales
from ..dynamics.evaluation.evaluation import evaluate
from ..dynamics.evaluation.series import driven_speeds
from ..dynamics.model.model import Model, new_workspace
from ..math.arrays import Array
from ..math.catalogue import Number
from ..math.laws import Powers
from .compiled import step_control as codes
from .compiled.cutoff import filter_error, new_cutoff, start_filter
from .compiled.pencil import freeze, new_frozen
from .compiled.radau_loop import advance
from .compiled.radau_stages import (
    MU,
    PENALTY,
    C,
    RadauWorkspace,
    new_radau_workspace,
    restart_radau,
)
from .compiled.step_control import Ends
from .generic.advice import IMPLICIT, OWN, SHORTER, WANTED, Pace, Refusals
from .generic.base import Dense
from .step_loop import ClosingLoop


def ringing(model: Model, workspace: RadauWorkspace) -> tuple[int, float]:
    """Return the component of the state that rings most in the last step, and its rate [rad/s].

    By the cubic coefficients of the step's polynomials: of a vibration that the step resolves,
    those of velocities are w times those of positions. Components are weighed by inertia.
    """
    cubic, n_pos, M = workspace.Q[2], model.n_pos, workspace.frozen.M
    size = np.zeros(model.n_vel)
    for i, j in enumerate(model.vel_start):
        for k in range(int(model.layout.size[i])):
            size[j + k] = M[i, k, k] * cubic[n_pos + j + k] ** 2
    most = int(np.argmax(size))
    i = int(np.searchsorted(model.vel_start, most, side="right")) - 1
    k, a = most - int(model.vel_start[i]), int(model.pos_start[i])
    turns, j = 3 <= k < 6, n_pos + most
    q = a + k + (1 if k > 5 else 0)
    swing = 2.0 * cubic[a + 3 : a + 7] if turns else cubic[q : q + 1]
    speed = cubic[j - k + 3 : j - k + 6] if turns else cubic[j : j + 1]
    size_q, size_v = float(np.linalg.norm(swing)), float(np.linalg.norm(speed))
    return j, size_v / size_q if size_q > 0.0 else 0.0


def kinetic_energies(
    model: Model, least: Array, t: float, y: Array, cutoff: float
) -> tuple[float, float]:
    """Return the kinetic energy of vibrations above a cutoff [rad/s], and of all motion [J].

    In state y (n,) at t [s], by the filter that takes such vibrations out of errors: motion without
    stiffness is not among them, however fast it is. `least` (n_e,): as of `new_cutoff`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    least : least stiffness that each element row has had (n_e,)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    cutoff : frequency above which a vibration counts [rad/s]
    """
    work, frozen = new_workspace(model), new_frozen(model)
    evaluate(model, work, t, y)
    freeze(model, work, t, y, frozen)
    memory = new_cutoff(model, frozen, least.copy())
    start_filter(model, frozen, memory, cutoff)
    filter_error(model, memory, cutoff, y)
    energies = np.zeros(2)
    for i, j in enumerate(np.asarray(model.vel_start) + model.n_pos):
        size, lead = int(model.layout.size[i]), int(model.layout.lead[i])
        M = frozen.M[i, :size, :size]
        lower = np.tril(M, -1)
        lower[:, lead:] = 0.0
        v = y[j : j + size]
        for k, w in enumerate((v - memory.error[j : j + size], v)):
            energies[k] += w @ lower @ w + 0.5 * (np.diag(M) * w) @ w
    return float(energies[0]), float(energies[1])


A_TURN = 0.1  # rad in a step, from which on the rotation itself asks for steps this short
# Speed of a rim that no material holds [m/s]: hoops of carbon fibre burst below 3000 m/s.
TOO_FAST = 1e4
GROWN = 10.0  # over the speeds of the start and the drives: these are asked for, not grown


class Turning(NamedTuple):
    """The body that turns fastest."""

    body: int
    spin: float  # [rad/s]
    rim: float  # spin times the radius of gyration about the frame [m/s]


def turning(model: Model, y: Array) -> Turning:
    """Return the body that turns fastest in state y (n,)."""
    first = model.n_pos + np.asarray(model.vel_start)[: model.n_body]
    spins = np.linalg.norm(y[first[:, None] + np.arange(3, 6)], axis=1)
    body = int(np.argmax(spins))
    square = float(np.trace(model.T00[body]) + 0.5 * np.trace(model.J0[body]))
    radius = np.sqrt(square / model.mass[body]) if model.mass[body] > 0.0 else 0.0
    return Turning(body, float(spins[body]), float(spins[body] * radius))


# Cutoffs that are tried against a stall, times pi over the interval of the results.
CUTOFFS = (10.0, 3.0, 1.0)
TURNS_TOO_FAST = (
    "The run is unstable: at t = {t:.6g} s a body rotates at {spin:.2g} rad/s (rim speed "
    "{rim:.2g} m/s, which no material holds), which limits the step size. "
    "Look for a feedback that is unstable, or for loads in other units."
)

PATIENCE = 4  # looks at a run that goes on stalled, before the next
# Part of the kinetic energy above a cutoff: with more than half, the motion itself would be damped.
MOTION = 0.5
NOTHING = 1e-20  # part of it that is rounding: no vibration is above the cutoff
FAINT = 1e-8  # part of it below which a law that chatters keeps the steps short, not a vibration


class Radau(ClosingLoop):
    """Radau IIA of order 5 for mechanisms (compiled/radau_loop.py).

    It is L-stable, so that modes stiffer than the motion are damped, not followed. Every step is
    brought back onto the constraints unless `closed` is false.
    """

    name = "radau"
    samples = True
    local_share = 0.5
    meaning = "implicit Runge-Kutta of order 5, the fastest where modes are stiff"
    place = 2
    order = 5
    rates_fit = True
    points = (0.0, *C.tolist())
    on_growth = (
        "Newton's iteration finds no answer for a step this long, or constraints contradict each "
        f"other: take a shorter step ({SHORTER})"
    )
    on_failure = IMPLICIT

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

    def shown_by(self, h: float) -> None:
        """Judge vibrations above pi / h, which states h [s] apart cannot show, by displacements.

        Their velocities would ask for steps that the motion does not need. A cutoff of the case has
        precedence, and rigid bodies have no vibrations.
        """
        if self._tries and np.any(self._model.n_mode):
            self._workspace.clock[codes.CUTOFF] = -np.pi / h

    def follow(self, pace: Pace) -> None:
        """Answer a stall by a cutoff, as high as ends it; end a run that turns beyond all measure.

        Short steps of a body that turns fast are those of its rotation: no cutoff changes them.
        Neither does one help rigid bodies, whose motion is no vibration, or a law that chatters,
        which is named; and a vibration with
        most of the kinetic energy is the motion itself, which no cutoff may damp.
        """
        stall = pace.stalled(self.t, self.counters.steps, self.counters.rejected)
        if stall is None:
            return
        fastest = turning(self._model, self.y)
        if fastest.spin * stall.step > A_TURN:
            if fastest.rim > TOO_FAST and self._is_beyond(fastest):
                self.status = "failed"
                self.message = TURNS_TOO_FAST.format(t=self.t, spin=fastest.spin, rim=fastest.rim)
            return
        cutoff = (self._tries or CUTOFFS)[0] * np.pi / pace.interval
        least = self._workspace.cutoff.held.stiffness
        energies = kinetic_energies(self._model, least, self.t, self.y, cutoff)
        self._kinetic = np.maximum(self._kinetic, energies)
        component, rate = ringing(self._model, self._workspace)
        faint = energies[0] <= NOTHING * energies[1] and rate * stall.step > OWN
        if faint or (self.chattering and energies[0] <= FAINT * energies[1]):
            return
        if not self.stalls:
            self.stalls = [stall._replace(component=component, rate=rate, remedy=self.on_stall)]
        elif self._patience > 0:
            self._patience -= 1
            return
        if self._tries and self._kinetic[0] <= MOTION * self._kinetic[1]:
            self._tries.pop(0)
            self._patience = PATIENCE
            self._workspace.clock[codes.CUTOFF] = cutoff
            self.stalls = [self.stalls[0]._replace(cutoff=cutoff)]

    def _is_beyond(self, fastest: Turning) -> bool:
        """Return whether the body turns far faster than the start and the drives prescribe."""
        model = self._model
        prescribed = np.abs(driven_speeds(model, np.array([self.t]), self.y)).max(initial=0.0)
        speed = scales(model, self._y_start, self.t_end).speed
        return bool(fastest.spin > GROWN * prescribed and fastest.rim > GROWN * speed)

    def refusals(self) -> Refusals:
        """Attempts that were refused so far, with the component that was most often the reason."""
        blamed = self._workspace.blamed
        component = int(np.argmax(blamed)) if blamed.any() else -1
        return super().refusals()._replace(component=component)

    @property
    def damped_energy(self) -> float:
        """Energy taken out of vibrations above the cutoff [J]."""
        return float(self._workspace.damped.sum())

    def for_loop(self, model: Model) -> Model:
        """Return the model with the softness of dependent rows that suits the iteration."""
        return model._replace(penalty=PENALTY) if model.penalty > 0.0 else model

    def _begin(self) -> Any:
        return new_radau_workspace(self._model, self.t, self.y, self._h_next)

    def _restart(self) -> None:
        restart_radau(self._model, self._workspace, self.t, False)

    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        return advance(self._model, self._options, self._workspace, most, times, rows, filled, ends)

    def _dense(self) -> Dense:
        workspace, h = self._workspace, self.h
        polynomial = Powers(self.t_old, h, workspace.y_old.copy(), workspace.Q.copy())
        return self._closed_inside(polynomial, MU / h) if self._closed else polynomial
