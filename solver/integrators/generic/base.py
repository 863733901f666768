"""The contract of every integrator: one step at a time; a failure is a status with a message.

An integrator knows y' = f(t, y) and numbers, never a body. It runs forward in time only.
Nothing here closes over a mechanism and the state is flat arrays, so that a step loop can
be compiled later without changing the contract.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from ...math.arrays import Array, distinct
from ...math.catalogue import Number
from . import advice
from .advice import OWN, Motion, Pace, Refusals, Stall
from .norm import ErrorNorm, first_step_size

Derivative = Callable[[float, Array], Array]
Jacobian = Callable[[float, Array], Array]
Dense = Callable[[Any], Array]
Projection = Callable[[float, Array], "Array | None"]
Hidden = Callable[[Array, Array, Derivative, ErrorNorm, bool], list[float]]

MAX_REFUSALS_NOT_FINITE = 25
ROUNDING = 1e-14  # of the end of a run: what breaks there does so after it
NEAR = 1e-9  # of a run: so near to equations that are not finite, these are why a step fails
# Of fixed steps, over the largest component in the first ones: no motion, the method.
DIVERGED, FIRST_STEPS = 1e12, 10


@dataclass
class Counters:
    """What a run has cost so far."""

    steps: int = 0  # accepted steps
    rejected: int = 0  # tried and taken back
    evaluations: int = 0  # calls of f, those for difference Jacobians included
    jacobians: int = 0
    factorisations: int = 0


class Integrator(ABC):
    """Carry y' = f(t, y) from t0 to t_end, one accepted step per call of `step`.

    A method derives from this class and provides `_attempt` (try one step of a given
    size) and `_dense` (the solution inside the last step). Everything else is here:
    limits of the step, counters, status. Read after each step: `t_old`, `t` [s],
    `y` (n,), `h` the step just taken [s], `order`, `counters`, `status`, `message`,
    `hints` (remarks on the choice of method).

    Parameters
    ----------
    f : derivative f(t, y) -> (n,); may hand back the same buffer each time, must not keep y
    t0, t_end : start and end [s], t_end > t0
    y0 : (n,) start values
    rtol, atol : tolerances of the local error, relative and absolute (scalar or (n,));
        atol = inf takes a component out of the error control
    first_step : size of the first step [s]; chosen from f if None
    max_step, min_step : bounds of the step [s]; below min_step (and below ten spacings of
        t in any case) the run ends as failed
    jacobian : df/dy (t, y) -> (n, n); only implicit methods use it
    block_starts : (b,) first index of each block of y; the error norm is the largest of
        the blocks' root mean squares. One block if None
    fixed_step : take this step [s] without error control (studies of stability and order); a
        state that grows 1e12-fold ends the run as failed
    kinks : (k,) times at which a step ends [s], ascending: f is continuous there, or nearly
    jumps : (k, 2) times before and after a jump of f [s]: a step ends at the first of them, the
        next one begins at the second
    project : (t, y) -> (n,) nearest state that satisfies the invariants of the problem, or None
        if there is none near by; applied to every step before it is accepted, and to the
        dense output

    Raises
    ------
    ValueError : an option that makes no sense; the message names it
    """

    # What a class that a case can name has of its own; integrators/contract.py.
    name: ClassVar[str] = ""  # in `[solver] integrator`; none: a base of others
    meaning: ClassVar[str] = ""
    place: ClassVar[int] = 100
    keys: ClassVar[tuple[Number, ...]] = ()
    treatments: ClassVar[tuple[str, ...]] = ()

    order: int
    strides = False  # has `stride(times, rows, filled)`: many steps in one call
    # Of the accuracy that is asked of a run, what the error of a step may be (docs/accuracy.md).
    local_share: ClassVar[float] = 1.0

    @classmethod
    def local_tolerance(cls, rtol: float, treatment: str) -> float:
        """Return the tolerance of a step of a run with `rtol` and a treatment of constraints."""
        return cls.local_share * rtol

    @classmethod
    def smallest_rtol(cls, treatment: str) -> float:
        """Return the rtol below which the error of a run falls more slowly than it."""
        return 0.0

    takes: ClassVar[str] = "derivative"  # or "model": its first argument

    # Whether it integrates auxiliary states of controllers, friction, angles over many turns.
    auxiliary: ClassVar[bool] = True
    samples: ClassVar[bool] = False  # and the jumps of those that are sampled

    # Words on runs that fail, without the full stop.
    on_growth: ClassVar[str] = ""  # a fixed step that makes the state grow, or fail
    fails_before_growth: ClassVar[bool] = False  # trouble shows in Newton's iteration, not in y
    on_failure: ClassVar[str] = advice.OTHERWISE
    on_any_failure: ClassVar[str] = ""  # behind the others
    on_stall: ClassVar[str] = advice.STALLED  # what helps a run of tiny steps
    # Of |h w| on average, above which stability and not accuracy limits the steps; None: nowhere.
    limited_above: ClassVar[float | None] = None

    points: ClassVar[tuple[float, ...]] = (0.0, 1.0)  # of a step at which f is evaluated
    hidden: Hidden | None = None  # looks for instants at which f varies unseen: force_variation.py
    most_hidden = 1000  # such instants of a run
    rates_fit = False  # whether coordinates change over a step by their rates, to the tolerance
    over_bends = False  # whether steps may go over bends of forces, as a tangent along them asks
    chattering: Mapping[int, float] = MappingProxyType({})  # expressions, and since when [s]
    unsearched = 0  # expressions whose breaks are too many to be found: breakpoints.py
    bounded_to = 0  # steps after which a bound by the fastest vibration is computed again
    vibrates = True  # whether anything in the system stores energy and could vibrate

    def __init__(
        self,
        f: Derivative,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        rtol: float = 1e-6,
        atol: float | Array = 1e-9,
        first_step: float | None = None,
        max_step: float = np.inf,
        min_step: float = 0.0,
        jacobian: Jacobian | None = None,
        block_starts: Sequence[int] | None = None,
        fixed_step: float | None = None,
        project: Projection | None = None,
        kinks: Array | None = None,
        jumps: Array | None = None,
    ) -> None:
        self.y: Array = np.array(y0, dtype=float)
        if self.y.ndim != 1 or self.y.size == 0 or not np.isfinite(self.y).all():
            raise ValueError(f"y0: expected a non-empty 1-D array of finite numbers, got {y0!r}")
        if not (np.isfinite(t0) and np.isfinite(t_end) and t_end > t0):
            raise ValueError(f"t_end: expected a finite time after t0 = {t0!r}, got {t_end!r}")
        for name, value in (("max_step", max_step), ("first_step", first_step)):
            if value is not None and not value > 0:
                raise ValueError(f"{name}: expected a step size above 0 s, got {value!r}")
        if fixed_step is not None and not 0 < fixed_step < np.inf:
            raise ValueError(f"fixed_step: expected a finite step above 0 s, got {fixed_step!r}")
        if not 0 <= min_step <= max_step:
            raise ValueError(
                f"min_step: expected 0 <= min_step <= max_step = {max_step!r}, got {min_step!r}"
            )
        self._f, self._project = f, project
        self.t0 = self.t_old = self.t = float(t0)
        self.t_end = float(t_end)
        self.n = self.y.size
        self.norm = ErrorNorm(self.n, rtol, atol, block_starts)
        self.jacobian = jacobian
        self.max_step, self.min_step, self.fixed_step = max_step, min_step, fixed_step
        self.longest_step = max_step
        self.h = 0.0
        self.status = "running"
        self.message = ""
        self.hints: list[str] = []
        self.stalls: list[Stall] = []
        self.counters = Counters()
        self._trouble = ""  # why the last attempt was refused
        self._stalled = ""  # why a method gives up
        self._raised = ""  # error raised inside f in this attempt
        self._not_finite = 0  # attempts in a row refused because of inf or nan
        self._wall = (-np.inf, "")  # where the last of them began, and why it was refused
        self._nan = np.full(self.n, np.nan)
        self._largest_first = float(np.abs(self.y).max())  # component, of a run of fixed steps
        self._growth = 1.0
        self._output: Dense | None = None
        self._kinks = np.zeros(0) if kinks is None else np.asarray(kinks, dtype=float)
        self._jumps = np.zeros((0, 2)) if jumps is None else np.asarray(jumps, dtype=float)
        self._kinks = self._kinks[self._kinks > self.t]
        self._jumps = self._jumps[self._jumps[:, 0] > self.t]
        self._find_stop()
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            self._f_start = np.array(self.derivative(self.t, self.y), dtype=float)
            if self._f_start.shape != self.y.shape:
                raise ValueError(
                    f"f: expected a derivative of shape {self.y.shape} like y0, "
                    f"got {self._f_start.shape}"
                )
            if not np.isfinite(self._f_start).all():
                self._refuse_not_finite("the derivative at the start")
                self._fail(f"Cannot start at t = {self.t:.9g} s")
            self._h_next = self._first_step(first_step)

    def step(self) -> None:
        """Take one accepted step, or set `status` to "failed" and say why in `message`.

        Raises
        ------
        RuntimeError : the run has already ended
        """
        if self.status != "running":
            raise RuntimeError(f"step() on an integrator that is {self.status}: {self.message}")
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            if self._stop <= self.t:
                jumps, self.t = self._behind > self.t, self._behind
                self._find_stop()
                self._go_behind(jump=jumps)
            self._advance()

    def _unseen(self, t: Array, y: Array) -> list[float]:
        """Return where steps with the ends t (k + 1,), y (k + 1, n) have to end, too."""
        return (
            []
            if self.hidden is None
            else self.hidden(t, y, self.derivative, self.norm, self.over_bends)
        )

    def _stop_also(self, times: list[float]) -> None:
        """Let steps end at these times [s], too: one of a force that has not been seen, or two."""
        self._kinks = distinct(self._kinks[self._kinks >= self.t], times)
        self.most_hidden -= len(times) == 1
        if self.most_hidden == 0:
            self.hidden = None

    def _find_stop(self) -> None:
        """Find where the next step ends at the latest, `_stop`, and goes on from, `_behind` [s]."""
        ends = [(float(t), float(t)) for t in self._next(self._kinks)]
        ends += [(float(a), float(b)) for a, b in self._next(self._jumps)]
        last = self.t_end * (1.0 - ROUNDING)
        near = [end for end in ends if end[1] < last]
        self._stop, self._behind = min(near, default=(self.t_end, self.t_end))

    def _next(self, stops: Array) -> Array:
        """Return the first of kinks or jumps after the present time, (1,) or (1, 2), or none."""
        times = stops if stops.ndim == 1 else stops[:, 0]
        k = int(np.searchsorted(times, self.t, "right"))
        return stops[k : k + 1]

    def _go_behind(self, *, jump: bool) -> None:
        """Go on behind a kink or jump of f at the present time, from the state there."""
        self._not_finite = 0

    def _advance(self) -> None:
        """Try steps until one is accepted, or fail."""
        while self.status == "running":
            h, t_new = self._limited_step()
            floor = self._smallest_step()
            if h < floor and t_new < self._stop:
                self._fail(f"The step at t = {self.t:.9g} s fell to {h:.3g} s, below {floor:.3g} s")
                return
            self._raised = ""
            y_new = self._attempt(h, t_new)
            if y_new is not None:
                self._accept(t_new, y_new, h)
                return
            self.counters.rejected += 1
            if self.fixed_step is not None:
                self._fail(f"The fixed step of {h:.3g} s fails at t = {self.t:.9g} s")
            elif self._stalled:
                self._fail(f"{self._stalled} at t = {self.t:.9g} s")
            elif self._not_finite > MAX_REFUSALS_NOT_FINITE:
                self._fail(f"No step however small succeeds at t = {self.t:.9g} s")

    def _smallest_step(self) -> float:
        return float(max(self.min_step, 10 * np.spacing(abs(self.t))))

    def _accept(self, t_new: float, y_new: Array, h: float) -> None:
        self.t_old, self.t, self.y, self.h = self.t, t_new, y_new, h
        self._output = None
        self._not_finite = 0
        self.counters.steps += 1
        if self.fixed_step is not None:
            # A run of fixed steps ends when its state has diverged.
            largest = float(np.abs(y_new).max())
            if self.counters.steps <= FIRST_STEPS:
                self._largest_first = max(self._largest_first, largest)
            self._growth = largest / self._largest_first if self._largest_first > 0 else 0.0
            if self._growth > DIVERGED:
                self._trouble = f"the state has grown {self._growth:.2g}-fold since the start"
                self._fail(f"The fixed step of {self.h:.3g} s diverges at t = {self.t:.9g} s")
        if self.status == "running" and t_new >= self.t_end:
            self.status, self.message = "finished", f"Reached t = {t_new:.9g} s"

    def dense_output(self) -> Dense:
        """Solution over [t_old, t]: callable of a time () or times (k,) giving (n,) or (k, n).

        Ask for it before the next call of `step`; the callable itself stays valid.
        """
        if self.counters.steps == 0:
            raise RuntimeError("dense_output() before the first accepted step")
        if self._output is None:
            inside = self._dense()
            self._output = inside if self._project is None else self._projected(inside)
        return self._output

    def derivative(self, t: float, y: Array) -> Array:
        """Evaluate f, counted; a numerical error raised inside f counts as not finite."""
        self.counters.evaluations += 1
        try:
            return self._f(t, y)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            self._raised = f"{type(error).__name__} in the derivative at t = {t:.9g} s: {error}"
            return self._nan

    def project(self, t: float, y: Array) -> Array | None:
        """State of a step on the invariants; None, with the reason kept, if none is near.

        None, too, for the end of a step inside which f varies without having been seen.
        """
        nearest: Array | None = y
        if self._project is not None:
            try:
                nearest = self._project(t, y)
            except (np.linalg.LinAlgError, ArithmeticError) as error:
                what = f"{type(error).__name__} in the projection at t = {t:.9g} s"
                self._trouble = f"{what}: {error}"
                return None
        if nearest is None or not np.isfinite(nearest).all():
            self._trouble = "the step cannot be projected onto the constraints"
            return None
        if self.hidden is not None and t > self.t:
            unseen = self._unseen(np.array([self.t, t]), np.stack([self.y, nearest]))
            if unseen:
                self._trouble = f"a force varies inside the step, at t = {unseen[0]:.9g} s"
                self._stop_also(unseen)
                self._find_stop()
                return None
        return nearest

    def _projected(self, inside: Dense) -> Dense:
        """Dense output on the invariants; left as it is where none are near."""

        def on_invariants(t: Any) -> Array:
            times = np.asarray(t, dtype=float)
            values = inside(times).reshape(-1, self.n)
            for k, t_k in enumerate(times.ravel()):
                nearest = self.project(float(t_k), values[k])
                values[k] = values[k] if nearest is None else nearest
            return values.reshape((*times.shape, self.n))

        return on_invariants

    def _attempt(self, h: float, t_new: float) -> Array | None:
        """Try one step; y at t_new, or None with `_h_next` made smaller and `_trouble` set.

        Every method has this, or an `_advance` of its own.
        """
        raise NotImplementedError

    @abstractmethod
    def _dense(self) -> Dense:
        """Solution inside the last accepted step."""

    def _limited_step(self) -> tuple[float, float]:
        """Step and its end: within max_step, on a stop exactly, no sliver before it."""
        remaining = self._stop - self.t
        if self.fixed_step is not None:
            h, stretch = self.fixed_step, 1 + 1e-6
        else:
            h, stretch = min(self._h_next, self.max_step), 1.01
        if h * stretch >= remaining:
            return remaining, self._stop
        return h, self.t + h

    def _refuse_not_finite(self, what: str) -> None:
        self._not_finite += 1
        self._trouble = self._raised or f"{what} is not finite (inf or nan)"
        self._wall = (self.t, self._trouble)

    def _fail(self, where: str) -> None:
        self.status = "failed"
        if not self._not_finite and self.t - self._wall[0] < NEAR * (self.t_end - self.t0):
            # Steps have crept up to where the equations end; other troubles of tiny steps follow.
            self._not_finite, self._trouble = 1, self._wall[1]
        unstable = self._growth > advice.GROWN or self.fails_before_growth
        hint = self.on_growth if self.fixed_step is not None and unstable else ""
        hint = hint or (advice.NOT_FINITE if self._not_finite > 0 else self.on_failure)
        if self.on_any_failure:
            hint = f"{hint}. {self.on_any_failure}"
        self.message = f"{where}; last refusal: {self._trouble or 'none'}. {hint}."

    def follow(self, pace: Pace) -> None:
        """Notice that the run has come to a stall; called between steps, or many of them.

        A law that chatters is the reason of its own, and named.
        """
        if self.stalls or self.chattering:
            return
        stall = pace.stalled(self.t, self.counters.steps, self.counters.rejected)
        if stall is not None:
            fastest = self.fastest_motion()
            if not self.vibrates and fastest.rate * stall.step > OWN:
                return
            stall = stall._replace(component=fastest.component, rate=fastest.rate)
            self.stalls.append(stall._replace(remedy=self.on_stall))

    @property
    def damped_energy(self) -> float:
        """Energy that the method has taken out of vibrations, as far as it counts it [J]."""
        return 0.0

    def refusals(self) -> Refusals:
        """Attempts that were refused so far."""
        c = self.counters
        step = (self.t - self.t0) / c.steps if c.steps else 0.0
        return Refusals(c.steps + c.rejected, c.rejected, step)

    def final_hints(self) -> tuple[str, ...]:
        """`hints`, and what a look back on a finished run adds (some evaluations of f)."""
        if (
            self.status == "failed"
            or self.hints
            or self.fixed_step is not None
            or self.counters.steps < advice.STEPS_WORTH_A_LOOK
        ):
            return tuple(self.hints)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return (*self.hints, *self._look_back((self.t - self.t0) / self.counters.steps))

    def _look_back(self, h_mean: float) -> list[str]:
        """Remarks on a finished run of mean step `h_mean` [s]."""
        if self.limited_above is None:
            return []
        rate = self.fastest_motion().rate
        return [] if h_mean * rate < self.limited_above else [advice.of_stability(h_mean, rate)]

    def fastest_motion(self) -> Motion:
        """Return the fastest motion about the present state; RATE_EVALUATIONS evaluations of f."""
        weight = self.norm.weight(self.y, self.y)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return advice.fastest_motion(self.derivative, self.t, self.y, weight)

    @classmethod
    def for_treatment(cls, name: str) -> dict[str, object]:
        """Return the options that follow from the treatment of constraints of a case."""
        return {}

    def _first_step(self, first_step: float | None) -> float:
        """Size of the first step from the sizes of y, f and the change of f along f."""
        if self.fixed_step is not None:
            return self.fixed_step
        span = self.t_end - self.t0
        if first_step is not None or self.status == "failed":
            return min(first_step or span, span)
        start = self.t, self.y, self._f_start
        return first_step_size(self.derivative, *start, self.norm, self.order, span, self.max_step)
