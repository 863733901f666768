"""Integrators of mechanisms whose step loop is compiled whole, behind the contract of all.

`right_hand_side` and `projection` give a model to integrators that do not know a body.
"""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..dynamics.analysis.projection import projected
from ..dynamics.elements.constraints.treatment import Treatment
from ..dynamics.evaluation.accelerations import by_blocks, dense_derivative_into, derivative_into
from ..dynamics.evaluation.elimination import is_tree
from ..dynamics.evaluation.instants import Called, Instants, beyond, first_crossing, sampled
from ..dynamics.evaluation.reactions import reads_reactions
from ..dynamics.model.model import Model, spare_workspace, state_size
from ..dynamics.tolerances import ONE_INSTANT
from ..math.arrays import Array, distinct
from ..math.compiled import COMPILED
from .compiled import step_control as codes
from .compiled.closing import close
from .compiled.step_control import Ends, Options
from .generic.advice import Refusals
from .generic.base import FIRST_STEPS, ROUNDING, Dense, Derivative, Integrator
from .generic.drive import Steps


def right_hand_side(model: Model) -> Derivative:
    """Return f(t, y) -> dy/dt of the index-1 system, each time in the same array."""
    work, out = spare_workspace(model), np.empty(state_size(model))
    fill = derivative_into if by_blocks(model) else dense_derivative_into

    def rate(t: float, y: Array) -> Array:
        fill(model, work, t, y, out)
        return out

    return rate


def projection(model: Model) -> Callable[[float, Array], Array | None]:
    """Return project(t, y) -> state on the constraints; None if none is near."""
    work = spare_workspace(model)

    def nearest(t: float, y: Array) -> Array | None:
        out, reached = projected(model, t, y, work)
        return out if reached else None

    return nearest


PLACES = ("_begun", "_stood", "_ends")  # no part of what a loop goes on from


def _among(times: Array, sharp: Array | None) -> Any:
    """Return which times are sharp. `np.isin` would import numpy.ma: 6 ms."""
    if sharp is None or not len(sharp):
        return np.zeros(len(times), dtype=bool)
    known = distinct(sharp)
    return known[np.minimum(np.searchsorted(known, times), len(known) - 1)] == times


class StrideMemory(Integrator):
    """An integrator of many steps in one call that can stand after any step of the last call.

    It keeps all that the steps depend on at the beginning of a stride, and takes them again.
    """

    _workspace: Any  # of the compiled loop
    _model: Model
    keeps_stages = False  # `radau`: whether steps that are kept have their stages

    def _forget(self) -> None:
        """Begin without a stride."""
        self._nowhere = np.empty(0), np.empty((0, self.n)), 0, self._room(0)
        self._ends = self._nowhere[3]
        self._begun: Any = None  # mark of the beginning of the last stride
        self._stood: Any = None  # step of it after which the loop stands, mark of its end

    def steps_taken(self) -> Steps:
        """Return the steps of the last stride; valid up to the next."""
        t, y = self._ends_since(self._begun)
        stages = (self._ends.Z[: t.size - 1], self._ends.multipliers[: t.size - 1])
        return Steps(t, y, self._stand, *(stages if self.keeps_stages else ()))

    def _room(self, count: int) -> Ends:
        """Return memory for `count` steps."""
        kept, rows = (count, self._model.layout.newton.place.size) if self.keeps_stages else (0, 0)
        return Ends(
            np.empty(count),
            np.empty((count, self.n)),
            np.empty((kept, 3, self.n)),
            np.empty((kept, 3, rows)),
        )

    def _ends_since(self, mark: Any) -> tuple[Array, Array]:
        """Return times (k + 1,) and states (k + 1, n) of the k steps since `mark`, with its own."""
        begun = mark[0]
        taken = self.counters.steps - begun["counters"].steps
        t = np.append(begun["t"], self._ends.t[:taken])
        return t, np.concatenate((begun["y"][None, :], self._ends.y[:taken]))

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

    def mark(self) -> Any:
        """Return all that the steps to come depend on, between two strides."""
        self.take_up()
        self._begun = None
        return self._mark()

    def go_back(self, mark: Any) -> None:
        """Stand again where `mark` was made."""
        self._stood = self._begun = None
        self._go_back(mark)

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

    @abstractmethod
    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        """Call the compiled loop for `most` steps."""

    @abstractmethod
    def _take_over(self, code: int) -> None:
        """Bring state and counters up to date, and say why a loop came back early."""


# Steps of one call, between which Ctrl-C takes effect without loss.
CHUNK = 200 if COMPILED else 5
FEW = min(4, CHUNK)  # behind a stop at a force that was not seen
MOST_KEPT = 500_000  # numbers of the steps of one call
LOCATED, MOST_PASSES = 64, 12  # steps between looks for events; passes to locate one
APART = 4.0  # lengths of a jump of a law of time: an instant so near is that of the jump
SETTLED = 1e-6  # part of a step: change of an instant that may be noise
TROUBLE = {
    codes.NEWTON: "the Newton iteration does not converge (or constraints contradict)",
    codes.TOO_ROUGH: "the local error exceeds the tolerance",
    codes.ILL: "the equations are not finite (inf or nan)",
    codes.OFF: "the step cannot be projected onto the constraints",
}


class StepLoop(StrideMemory):
    """An integrator over a compiled loop: steps one by one, or many in one call.

    Parameters
    ----------
    model : a mechanism, treated (constraints/treatment.py)
    functions : of sampled states (dynamics/evaluation/events.py)
    sharp : those of `kinks` behind which forces have other rates
    t0, y0, t_end, others : see Integrator; `jacobian` and `project` are not used here
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
        sharp: Array | None = None,
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
            float(self.norm.rtol),
            np.broadcast_to(np.asarray(self.norm.atol, dtype=float), (self.n,)).copy(),
            np.append(options.get("block_starts") or [0], self.n).astype(np.int64),
            float(self.max_step),
            float(self.min_step),
            float(self.fixed_step or 0.0),
            self._kinks,
            _among(self._kinks, sharp),
            np.zeros(0),
            self._closes(),
        )
        self._h_next = float(self._h_next)  # the loops are compiled for numbers of one kind
        self._workspace = self._begin()
        if self.status == "running":
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                self._restart()
            self.counters.evaluations += 1
        self._evaluated = self.counters.evaluations
        self._forget()
        self._pace = CHUNK  # steps of the next call, if forces may hide
        self._before, self._behind = -np.inf, -np.inf  # next jump of a law of time
        self._set_instants()
        events = self._model.quantities.event_state.size
        self._armed: tuple[bool, ...] = ()  # of events (dynamics/evaluation/events.py)
        self._struck: tuple[int, ...] = ()  # events at the present state, not yet followed
        if events:
            self._armed = tuple((beyond(self._model, self.t, self.y)[:, 0] < 0.0).tolist())
        self._stop_at_next(self.t)

    def stride(self, times: Array, rows: Array, filled: int, keep: bool = False) -> int:
        """Take up to CHUNK steps; the solution at `times` (k,) goes to `rows` (k, n).

        Returns the number of rows filled, of which `filled` were there already. `keep`: keep what
        `steps_taken` needs.

        Parameters
        ----------
        times : output times (k,) [s]
        rows : solution at these times (k, n), to fill
        filled : number of rows filled before
        keep : keep what `steps_taken` needs
        """
        self._sample()
        watched = self.fixed_step is not None and self.counters.steps < FIRST_STEPS
        ends = keep or self.hidden is not None
        if ends and (self._begun is None or not self._ends.t.size):
            most = max(10, min(CHUNK, MOST_KEPT // self.n))
            self._ends = self._room(most)
        most = 1 if watched else self._ends.t.size if ends else CHUNK
        self._begun, self._stood = self._mark() if keep else None, None
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            if self._armed:
                return self._up_to_event(most, times, rows, filled, keep=keep)
            return self._take(min(most, self._pace), times, rows, filled, keep=keep)

    def _take(
        self, most: int, times: Array, rows: Array, filled: int, *, keep: bool = False
    ) -> int:
        """Take up to `most` steps, none over a force that varies unseen; as `stride`.

        The ends of the steps are in `_ends`; `keep`: `_begun` is the mark of the present state.
        """
        while True:
            begun = self._begun if keep or self.hidden is None else self._mark()
            code, reached = self._call(most, times, rows, filled, self._ends)
            self._take_over(code)
            if self.hidden is None:
                return reached
            t, y = self._ends_since(begun)
            unseen = self._unseen(t, y)
            if not unseen:
                self._pace = min(2 * self._pace, CHUNK)
                return reached
            self._go_back(begun)
            self._stop_also(unseen)
            # The steps before it are taken again once. The next stop is about as many ahead.
            steps = int(np.searchsorted(t, unseen[0]))
            most, self._pace = max(steps - 1, 1), max(steps, FEW)
            broken = unseen if len(unseen) > 1 else []  # forces have other rates behind it
            sharp = np.append(self._options.kinks[self._options.sharp], broken)
            sharp = _among(self._kinks, sharp)
            self._options = self._options._replace(kinks=self._kinks, sharp=sharp)
            self._workspace.clock[codes.KINK] = 0.0
            if keep:  # the steps are taken again from here, with the stops
                self._begun = self._mark()

    def _up_to_event(
        self, most: int, times: Array, rows: Array, filled: int, *, keep: bool = False
    ) -> int:
        """Take steps as `stride` does, up to the first event, whose instant is located."""
        if not keep:
            self._ends = self._room(LOCATED)
        most, begun = min(most, LOCATED), self._mark()
        event, last, clock = -1, np.inf, self._workspace.clock
        for passes_left in range(MOST_PASSES - 1, -1, -1):
            reached = self._take(most, times, rows, filled, keep=keep)
            t, y = self._ends_since(begun)
            if event >= 0 and len(t) > 1:
                gap, rate = beyond(self._model, self.t, self.y)[event]
                late = gap / rate if rate > 0.0 else 0.0
                if abs(late) < ONE_INSTANT * max(1.0, abs(self.t)) or self.t < clock[codes.END]:
                    break
                # residual error of Newton's iteration: it differs from pass to pass
                noise = abs(late) < SETTLED * self.h and abs(late) > 0.5 * last
                if noise or passes_left == 0:
                    break
                at, last = self.t - late, abs(late)
            else:
                armed, event, at = first_crossing(self._model, t, y, self._armed)
                if event < 0:
                    self._armed = armed
                    return reached
            self._go_back(begun)
            if at - self.t < ONE_INSTANT * max(1.0, abs(self.t)):
                clock[codes.END] = self.t
                reached = filled
                break
            clock[codes.END] = at
            begun = self._mark()
            self._begun = begun if keep else None
        self._struck = (event,)
        self._armed = tuple(one and e != event for e, one in enumerate(self._armed))
        return reached

    @property
    def at_event(self) -> bool:
        """Whether the last stride has ended at an event, which the next one follows."""
        return bool(self._struck)

    def go_on(self, t_end: float) -> None:
        """Let the run end at t_end [s]; up to there it restarts from the present state.

        For a run that has finished, or not begun, after laws of time in the model have changed.
        """
        if self._kinks.size or self._jumps.size:  # none a rounding error behind the end
            stops = np.append(self._kinks, self._jumps[:, 0])
            near = stops[(stops > t_end) & (stops <= t_end * (1.0 + ROUNDING))]
            t_end = float(max(near, default=t_end))
        self.t_end, self.status, self.message = t_end, "running", ""
        self._set_instants()
        clock = self._workspace.clock
        clock[codes.END] = self.t
        # The last step may have been a rounding error up to the end: not the size to go on with.
        clock[codes.NEXT] = max(clock[codes.NEXT], 10.0 * self._smallest_step())

    def _set_instants(self) -> None:
        """Find when controllers act; the loop samples by itself what needs neither Python nor look.

        Functions of a user, states that change at events, and forces that read reactions are
        sampled between two calls of the loop; so are instants at a jump of a law of time.
        """
        model = self._model
        self._instants = Instants(model, self.t_end, self.t)
        t = self._instants.t
        self._workspace.clock[codes.INSTANT] = 0.0
        if not t.size + self._options.instants.size:
            return
        between = np.ones(t.size, dtype=bool)
        if not (self._functions or model.quantities.event_state.size or reads_reactions(model)):
            between[:] = False
            for before, behind in self._jumps.tolist():
                apart = behind - before
                first, last = np.searchsorted(t, (before - apart, behind + APART * apart))
                between[first:last] = True
        self._instants.t = t[between]
        self._options = self._options._replace(instants=t[~between])

    def _sample(self) -> None:
        """Sample controllers where the loop stands at an instant, and go on from there."""
        clock = self._workspace.clock
        if self.t < clock[codes.END] or self.t >= self.t_end:
            return
        if self.t == self._before:
            self.t = clock[codes.TIME] = self._behind
        if self._model.n_aux:
            which = self._instants.sampled_at(self.t) & (self.t > self.t0)  # not the start again
            which[self._model.quantities.event_state[list(self._struck)]] = True
            if self._struck:  # what was before has no force that begins here
                clock[codes.TAKEN] = 0.0
            self._struck = ()
            if which.any():
                self.y = sampled(self._model, self.t, self.y, which, self._functions)
        self._workspace.y[:] = self.y
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            self._restart()
        self._evaluated += 1
        self._stop_at_next(self.t)

    def _stop_at_next(self, t: float) -> None:
        """Let the loop end at the next instant after t."""
        times = self._instants.t
        # One a rounding error ahead was sampled at t (Instants.sampled_at).
        k = int(np.searchsorted(times, t * (1.0 + ROUNDING), side="right"))
        end = float(times[k]) if k < times.size else self.t_end
        for before, behind in self._next(self._jumps).tolist():
            apart = behind - before
            if before < end + apart and behind < self.t_end * (1.0 - ROUNDING):
                # an instant of sampling at the jump is the same
                same = end < self.t_end and abs(end - behind) < APART * apart
                self._before, self._behind = before, max(behind, end) if same else behind
                end = before
        self._workspace.clock[codes.END] = end

    @abstractmethod
    def _restart(self) -> None:
        """Go on from the state of the workspace as from a start: evaluate its rate."""

    def _find_stop(self) -> None:
        self._stop = self._behind = self.t_end  # the loop has stops of its own

    def _advance(self) -> None:
        self._sample()
        if self._armed:
            self._up_to_event(1, *self._nowhere[:3])
        elif self.hidden is None:
            code, _ = self._call(1, *self._nowhere)
            self._take_over(code)
        else:
            self._ends = self._room(1)
            self._take(1, *self._nowhere[:3])

    def _take_over(self, code: int) -> None:
        """Bring state and counters up to date, and say why a loop came back early."""
        clock, counts = self._workspace.clock, self._workspace.counts
        taken = int(counts[codes.STEPS]) - self.counters.steps
        if taken > 0:
            self.counters.steps += taken - 1
            self._accept(clock[codes.TIME], self._workspace.y.copy(), clock[codes.LENGTH])
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
        return super().refusals()._replace(newton=newton, rough=rough)

    def _closes(self) -> bool:
        return False

    def _closed_inside(self, polynomial: Dense, s: float) -> Dense:
        """Return values of a step brought onto the constraints, in the metric of s [1/s].

        Those of its two ends stay as the step left them.
        """
        model, workspace, ends = self._model, self._workspace, (self.t_old, self.t)

        def inside(t: Any) -> Array:
            times = np.asarray(t, dtype=float)
            values = polynomial(times.ravel())
            for time, row in zip(times.ravel(), values, strict=True):
                if time in ends:
                    continue
                close(model, workspace, s, time, row, workspace.apart)
            return values.reshape((*times.shape, self.n))

        return inside

    def for_loop(self, model: Model) -> Model:
        """Return the model that the loop is called with."""
        return model

    @abstractmethod
    def _begin(self) -> Any:
        """Return the workspace of the run, which `_restart` begins."""


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
    def for_treatment(cls, name: str) -> dict[str, object]:
        """Whether steps go back onto the constraints."""
        return {"closed": name == "projection"}

    def _closes(self) -> bool:
        return self._closed
