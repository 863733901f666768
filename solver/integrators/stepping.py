"""Integrators of mechanisms whose step loop is compiled whole, behind the contract of all."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..dynamics.auxiliary import Called, Instants, sampled
from ..dynamics.constraints.treatment import Treatment
from ..dynamics.crossings import NOTHING, beyond, first_crossing
from ..dynamics.dependence import is_tree
from ..dynamics.model import Model
from ..dynamics.system import by_blocks, derivative_into
from ..dynamics.workspace import new_work, spare_work
from ..math.arrays import Array
from ..math.compiled import COMPILED
from ..math.keys import Number
from .closures import right_hand_side
from .compiled import step_control as codes
from .compiled.alpha import advance_alpha
from .compiled.alpha_workspace import new_alpha_workspace
from .compiled.closing import close
from .compiled.dependent_rows import PENALTY
from .compiled.radau import advance
from .compiled.radau_workspace import new_radau_workspace, restart_radau
from .compiled.step_control import Ends, Options
from .compiled.tableau import MU
from .generic import Integrator
from .generic.advice import SHORTER, of_choice
from .generic.alpha_scheme import FORMULATIONS, SPECTRAL_RADIUS, scheme
from .generic.base import FIRST_STEPS, Dense
from .generic.explicit import Powers
from .generic.hermite import Hermite
from .generic.pace import Pace, Refusals
from .generic.steps import Steps
from .ringing import ringing

# Steps of one call, between which Ctrl-C is heard without loss.
LOCATED, MOST_PASSES = 64, 12  # steps between looks for events; passes to locate one
CHUNK = 200 if COMPILED else 5
MOST_KEPT = 500_000  # numbers of the steps of one call
# Cutoffs that are tried against a stall, times pi over the interval of the results.
CUTOFFS = (10.0, 3.0, 1.0)
PATIENCE = 4  # looks at a run that goes on stalled, before the next
PLACES = ("_begun", "_stood", "_ends")  # no part of what a loop goes on from
TROUBLE = {
    codes.NEWTON: "the Newton iteration does not converge (or constraints contradict)",
    codes.TOO_ROUGH: "the local error exceeds the tolerance",
    codes.ILL: "the equations are not finite (inf or nan)",
    codes.OFF: "the step cannot be projected onto the constraints",
}


class StepLoop(Integrator):
    """An integrator over a compiled loop: steps one by one, or many in one call.

    Parameters
    ----------
    model : a mechanism, treated (constraints/treatment.py)
    functions : of sampled states (dynamics/auxiliary.py)
    t0, y0, t_end, others : see Integrator; `jacobian` and `project` are of no use here
    """

    strides = True
    takes = "model"
    fails_before_growth = True

    def __init__(
        self,
        model: Model,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        functions: Sequence[Called] = (),
        **options: Any,
    ) -> None:
        if functions:
            y0 = sampled(model, t0, y0, model.quantities.period > 0.0, functions)
        self._functions = functions
        if not by_blocks(model):
            # Rows that depend on each other: of effect on Newton's matrix, not on the motion.
            model = model._replace(penalty=Treatment.penalty)
        elif is_tree(model):
            model = model._replace(penalty=0.0)  # nothing to soften
        self._model = self.for_loop(model)
        super().__init__(right_hand_side(model), t0, y0, t_end, **options)
        self._options = Options(
            self.t_end,
            float(self.norm.rtol),
            np.broadcast_to(np.asarray(self.norm.atol, dtype=float), (self.n,)).copy(),
            np.append(options.get("block_starts") or [0], self.n).astype(np.int64),
            float(self.max_step),
            float(self.min_step),
            float(self.fixed_step or 0.0),
            self._closes(),
        )
        work, rate = new_work(model), np.zeros(self.n)
        if self.status == "running":
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                derivative_into(model, work, self.t, self.y, rate)
            self.counters.evaluations += 1
        self._h_next = float(self._h_next)  # the loops are compiled for numbers of one kind
        self._workspace = self._begin(rate, work.multipliers)
        self._evaluated = self.counters.evaluations
        nowhere = np.empty(0), np.empty((0, self.n))
        self._nowhere = *nowhere, 0, Ends(*nowhere)
        self._ends = self._nowhere[3]
        self._begun: Any = None  # mark of the beginning of the last stride
        self._stood: Any = None  # step of it after which the loop stands, mark of its end
        self._instants = Instants(model, self.t_end)
        events = self._model.quantities.event_state.size
        self._armed: tuple[bool, ...] = ()  # of events (dynamics/crossings.py)
        self._struck: tuple[int, ...] = ()  # events at the present state, not yet followed
        if events:
            self._armed = tuple((beyond(self._model, self.t, self.y)[:, 0] < 0.0).tolist())
        self._stop_at_next(self.t)

    def stride(self, times: Array, rows: Array, filled: int, keep: bool = False) -> int:
        """Take up to CHUNK steps; the solution at `times` (k,) goes to `rows` (k, n).

        Returns the number of rows filled, of which `filled` were there already. `keep`: keep what
        `steps_taken` needs.
        """
        self._sample()
        watched = self.fixed_step is not None and self.counters.steps < FIRST_STEPS
        if keep and self._begun is None:
            most = max(10, min(CHUNK, MOST_KEPT // self.n))
            self._ends = Ends(np.empty(most), np.empty((most, self.n)))
        most = 1 if watched else self._ends.t.size if keep else CHUNK
        self._begun, self._stood = self._mark() if keep else None, None
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            if self._armed:
                return self._up_to_event(most, times, rows, filled, keep=keep)
            code, filled = self._call(most, times, rows, filled, self._ends)
        self._take_over(code)
        return filled

    def _up_to_event(
        self, most: int, times: Array, rows: Array, filled: int, *, keep: bool = False
    ) -> int:
        """Take steps as `stride` does, up to the first event, whose instant is located."""
        if not keep:
            self._ends = Ends(np.empty(LOCATED), np.empty((LOCATED, self.n)))
        most, begun = min(most, LOCATED), self._mark()
        found, taken = -1, 0
        for _ in range(MOST_PASSES):
            code, reached = self._call(most, times, rows, filled, self._ends)
            self._take_over(code)
            taken = self.counters.steps - begun[0]["counters"].steps
            t = np.append(begun[0]["t"], self._ends.t[:taken])
            y = np.concatenate((begun[0]["y"][None, :], self._ends.y[:taken]))
            if found >= 0 and taken:
                gap, rate = beyond(self._model, self.t, self.y)[found]
                late = gap / rate if rate > 0.0 else 0.0
                if abs(late) < NOTHING * max(1.0, abs(self.t)) or self.t < self._options.t_end:
                    break
                at = self.t - late
            else:
                armed, found, at = first_crossing(self._model, t, y, self._armed)
                if found < 0:
                    self._armed = armed
                    return reached
            self._go_back(begun)
            if at - self.t < NOTHING * max(1.0, abs(self.t)):
                self._options = self._options._replace(t_end=self.t)
                reached = filled
                break
            self._options = self._options._replace(t_end=at)
            begun = self._mark()
            self._begun = begun if keep else None
        self._struck = (found,)
        self._armed = tuple(one and e != found for e, one in enumerate(self._armed))
        return reached

    def go_on(self, t_end: float) -> None:
        """Let the run end at t_end [s]; up to there it restarts from the present state.

        For a run that has finished, or not begun, after laws of time in the model have changed.
        """
        self.t_end, self.status, self.message = float(t_end), "running", ""
        self._instants = Instants(self._model, self.t_end)
        self._options = self._options._replace(t_end=self.t)

    def steps_taken(self) -> Steps:
        """Return the steps of the last stride; valid up to the next."""
        begun = self._begun[0]
        taken = self.counters.steps - begun["counters"].steps
        t = np.append(begun["t"], self._ends.t[:taken])
        y = np.concatenate((begun["y"][None, :], self._ends.y[:taken]))
        return Steps(t, y, self._stand)

    def _stand(self, i: int) -> Integrator:
        """Stand after step i of the last stride, by taking the steps up to there again."""
        if self._stood is None:
            self._stood = -1, self._mark()
            self._go_back(self._begun)
        stood, end = self._stood
        if i < stood:
            self._go_back(self._begun)
            stood = -1
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for count in (i - stood - 1, 1 if i > stood else 0):  # the last one by itself: t_old
                if count > 0:
                    code, _ = self._call(count, *self._nowhere)
                    self._take_over(code)
        self._stood = i, end
        return self

    def take_up(self) -> None:
        """Stand at the end of the last stride, however much of it was looked at."""
        if self._stood is not None:
            self._go_back(self._stood[1])
            self._stood = None

    def take_back(self, count: int) -> None:
        """Stand after the first `count` steps of the last stride: the others were not taken."""
        if count > 0:
            self._stand(count - 1)
            self._stood = count - 1, self._mark()
        else:
            self._go_back(self._begun)
            self._stood = None

    def _mark(self) -> Any:
        """Return all that the steps to come depend on."""
        kept = {name: value for name, value in vars(self).items() if name not in PLACES}
        kept |= {"counters": replace(self.counters), "hints": list(self.hints)}
        return kept, [
            (array, array.copy()) for array in self._workspace if isinstance(array, np.ndarray)
        ]

    def _go_back(self, mark: Any) -> None:
        kept, arrays = mark
        vars(self).update(kept | {"counters": replace(kept["counters"])})
        for array, values in arrays:
            array[...] = values

    def _sample(self) -> None:
        """Sample controllers where the loop stands at an instant, and go on from there."""
        if self.t < self._options.t_end or self.t >= self.t_end:
            return
        which = self._instants.sampled_at(self.t) & (self.t > self.t0)  # not the start again
        which[self._model.quantities.event_state[list(self._struck)]] = True
        self._struck = ()
        self.y = sampled(self._model, self.t, self.y, which, self._functions)
        rate, work = np.zeros(self.n), spare_work(self._model)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            derivative_into(self._model, work, self.t, self.y, rate)
        self._evaluated += 1
        self._restart(rate, work.multipliers)
        self._stop_at_next(self.t)

    def _stop_at_next(self, t: float) -> None:
        """Let the loop end at the next instant after t."""
        times = self._instants.t
        k = int(np.searchsorted(times, t, side="right"))
        end = float(times[k]) if k < times.size else self.t_end
        self._options = self._options._replace(t_end=end)

    def _restart(self, rate: Array, multipliers: Array) -> None:
        """Go on from the present state as from a start, with its rate and multipliers."""
        raise NotImplementedError

    def _advance(self) -> None:
        self._sample()
        if self._armed:
            self._up_to_event(1, *self._nowhere[:3])
            return
        code, _ = self._call(1, *self._nowhere)
        self._take_over(code)

    def _take_over(self, code: int) -> None:
        """Bring state and counters up to date, and say why a loop came back early."""
        clock, counts = self._workspace.clock, self._workspace.counts
        taken = int(counts[codes.STEPS]) - self.counters.steps
        if taken > 0:
            self.counters.steps += taken - 1
            self._accept(clock[codes.TIME], self._workspace.y.copy(), clock[codes.TAKEN])
            if taken > 1:
                self.t_old = self.t - self.h
        self.counters.rejected = int(counts[codes.REJECTED])
        self.counters.evaluations = self._evaluated + int(counts[codes.EVALUATIONS])
        self.counters.jacobians = int(counts[codes.JACOBIANS])
        self.counters.factorisations = int(counts[codes.FACTORISATIONS])
        if code in (codes.ARRIVED, codes.PAUSED):
            return
        trouble = int(counts[codes.TROUBLE])
        self._trouble = TROUBLE.get(trouble, "")
        self._not_finite = int(trouble == codes.ILL)
        t, h = clock[codes.TIME], clock[codes.NEXT]
        if code == codes.TOO_SMALL:
            floor = max(self._smallest_step(), codes.SMALLEST)
            self._fail(f"The step at t = {t:.9g} s fell to {h:.3g} s, below {floor:.3g} s")
        elif code == codes.REFUSED:
            self._fail(f"The fixed step of {self.fixed_step:.3g} s fails at t = {t:.9g} s")
        else:
            self._fail(f"No step however small succeeds at t = {t:.9g} s")

    def refusals(self) -> Refusals:
        """Attempts that were refused so far, with the reasons."""
        why = self._workspace.counts[codes.BECAUSE :]
        newton, rough = int(why[codes.NEWTON]), int(why[codes.TOO_ROUGH])
        return replace(super().refusals(), newton=newton, rough=rough)

    def _closes(self) -> bool:
        return False

    def _closed_inside(self, polynomial: Dense, s: float) -> Dense:
        """Return values of a step brought onto the constraints, in the metric of s [1/s].

        Those of its two ends stay as the step left them.
        """
        model, c, ends = self._model, self._workspace, (self.t_old, self.t)

        def inside(t: Any) -> Array:
            times = np.asarray(t, dtype=float)
            values = polynomial(times.ravel())
            for time, row in zip(times.ravel(), values, strict=True):
                if time in ends:
                    continue
                close(model, c.work, c.frozen, c.real, s, time, row, c.apart)
            return values.reshape((*times.shape, self.n))

        return inside

    def for_loop(self, model: Model) -> Model:
        """Return the model that the loop is called with."""
        return model

    @abstractmethod
    def _begin(self, rate: Array, multipliers: Array) -> Any:
        """Return the workspace of the run."""

    @abstractmethod
    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        """Call the compiled loop for `most` steps."""


class ClosingLoop(StepLoop):
    """A step loop that brings every step back onto the constraints, unless `closed` is false."""

    def __init__(
        self,
        model: Model,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        closed: bool = True,
        **options: Any,
    ) -> None:
        self._closed = closed and model.n_constraint > 0
        super().__init__(model, t0, y0, t_end, **options)

    @classmethod
    def for_treatment(cls, name: str) -> dict[str, Any]:
        """Whether steps go back onto the constraints."""
        return {"closed": name == "projection"}

    def _closes(self) -> bool:
        return self._closed


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
        "fewer modes; or rtol and atol_velocity that do not ask for the vibration"
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

    def follow(self, pace: Pace) -> None:
        """Answer a stall by a cutoff, as high as ends it."""
        found = pace.stalled(self.t, self.counters.steps, self.counters.rejected)
        if found is None:
            return
        if not self.stalls:
            component, rate = ringing(self._model, self._workspace)
            self.stalls = [replace(found, component=component, rate=rate, remedy=self.on_stall)]
        elif self._patience > 0:
            self._patience -= 1
            return
        if self._tries:
            cutoff = self._tries.pop(0) * np.pi / pace.interval
            self._patience = PATIENCE
            self._workspace.clock[codes.CUTOFF] = cutoff
            self.stalls = [replace(self.stalls[0], cutoff=cutoff)]

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


class GeneralizedAlpha(StepLoop):
    """Generalized-alpha of Arnold and Bruls for M a + Phi_q' lambda = f, Phi = 0.

    Second order; q moves by the group's exponential (dynamics/coordinates.py), so that Euler
    parameters need no constraint of their own. With spectral radius rho at infinity,

        alpha_m = (2 rho - 1) / (rho + 1), alpha_f = rho / (rho + 1),
        gamma = 1/2 + alpha_f - alpha_m, beta = (gamma + 1/2)^2 / 4,
        (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) vdot_1 + alpha_f vdot_0,
        z = h v_0 + h^2 ((1/2 - beta) a_0 + beta a_1),  v_1 = v_0 + h ((1 - gamma) a_0 + gamma a_1).

    Formulations:
      index3  q_1 = q_0 exp(z); Phi(q_1) = 0. Velocities satisfy the constraints to h^2 only, and
              multipliers swing after a change of step.
      ggl     q_1 = q_0 exp(z + p) with p = -J^-1 Phi_q' eta, J being Newton's matrix (the position
              multiplier of Gear, Leimkuhler and Gupta); Phi(q_1) = 0 and Phidot(q_1, v_1) = 0.
              Default.

    Newton's unknowns are z and h^2 lambda: scaled so, the matrix stays well conditioned as h
    tends to zero. rho = 1 keeps the energy of what it does not resolve, rho = 0 destroys it in
    one step.

    Parameters
    ----------
    formulation : "ggl" or "index3"
    spectral_radius : rho, 0 to 1
    others : see Integrator. With fixed_step only Newton's iteration uses the tolerances.
    """

    name = "generalized-alpha"
    local_share = 0.03
    meaning = "implicit, for constraints = ggl or index3"
    place = 5
    keys = (
        Number(
            "spectral_radius",
            "",
            "of generalized-alpha at infinite frequency: 1 gives no damping",
            default=SPECTRAL_RADIUS,
            least=0,
            most=1,
        ),
    )
    treatments = FORMULATIONS
    auxiliary = False
    order = 2
    # What it does not damp shows in its multipliers, not in the state.
    on_growth = (
        "With too little damping (spectral_radius near 1) what the step does not resolve can grow "
        'where the problem is not linear, and with constraints = "index3" the velocities that the '
        'constraints forbid swing on: take spectral_radius = 0.8, constraints = "ggl", or a '
        f"shorter step ({SHORTER})"
    )

    def __init__(
        self,
        model: Model,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        formulation: str = "ggl",
        spectral_radius: float = SPECTRAL_RADIUS,
        **options: Any,
    ) -> None:
        self._scheme = scheme(formulation, spectral_radius)
        super().__init__(model, t0, y0, t_end, **options)
        self.hints += of_choice(formulation, spectral_radius)

    @classmethod
    def for_treatment(cls, name: str) -> dict[str, Any]:
        """Formulation."""
        return {"formulation": name}

    def _begin(self, rate: Array, multipliers: Array) -> Any:
        return new_alpha_workspace(self._model, self.t, self.y, rate, multipliers, self._h_next)

    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        model, options, workspace = self._model, self._options, self._workspace
        return advance_alpha(
            model, options, self._scheme, workspace, most, times, rows, filled, ends
        )

    def _dense(self) -> Dense:
        c, h = self._workspace, self.h
        ends = (c.y_old.copy(), c.rate_old.copy(), c.y.copy(), c.rate.copy())
        cubic, s = Hermite(self.t_old, h, *ends), self._scheme.to_a**0.5 / h
        return self._closed_inside(cubic, s) if self._model.n_constraint > 0 else cubic
