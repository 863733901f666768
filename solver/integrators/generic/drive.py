"""Run an integrator to its end, show its steps, and keep the solution at requested times."""

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...math.arrays import Array
from ...math.records import record
from ...math.rows import IN_MEMORY, StoredRows
from .advice import Pace, Refusals, Stall
from .base import Counters, Dense, Integrator

# Requested output times of a run, and the rows of its solution at them, in memory or in a file.

WINDOW = 16_000_000  # bytes of rows in memory if there are too many for it


class Output:
    """Rows of the requested times (k,).

    Integrators fill `rows` from `filled` on, at the times `window`. A full window goes to the file.

    Parameters
    ----------
    times : (k,) [s], ascending
    n : numbers in a row
    folder : for a file; None: that of temporary files
    """

    def __init__(self, times: Array, n: int, folder: Path | None = None) -> None:
        self.times = times
        self._stored: StoredRows | None = None
        room = times.size
        if 8 * n * times.size > IN_MEMORY:
            self._stored, room = StoredRows((n,), folder), max(WINDOW // (8 * n), 16)
        self.rows = np.empty((room, n))
        self.filled = 0

    @property
    def in_parts(self) -> bool:
        """Whether there are more times than rows in memory."""
        return self._stored is not None

    @property
    def kept(self) -> int:
        """Number of rows in the file."""
        return 0 if self._stored is None else len(self._stored)

    @property
    def count(self) -> int:
        """Number of rows filled, in memory and in the file."""
        return self.kept + self.filled

    @property
    def window(self) -> Array:
        """Times of `rows`, (w,)."""
        return self.times[self.kept : self.kept + len(self.rows)]

    @property
    def next_time(self) -> float:
        """First time that the window has no room for; infinite if there is none."""
        at = self.kept + len(self.rows)
        return float(self.times[at]) if at < self.times.size else np.inf

    def make_room(self) -> None:
        """Put a full window into the file, if more times follow."""
        if self._stored is not None and self.filled == len(self.rows):
            self._stored.append(self.rows)
            self.filled = 0

    def cut(self, count: int) -> None:
        """Drop all rows but the first `count`."""
        if self._stored is not None and count < len(self._stored):
            self._stored.cut(count)
        self.filled = max(min(self.filled, count - self.kept), 0)

    def all(self, *more: tuple[float, Array]) -> tuple[Array, Any]:
        """Return times (k,) and rows (k, n), an array or StoredRows; with one more where given."""
        t, rows = self.times[: self.count], self.rows[: self.filled]
        for t_more, y_more in more:
            t, rows = np.append(t, t_more), np.vstack((rows, y_more))
        if self._stored is None:
            return t, rows
        self._stored.append(rows)
        self.filled = 0
        return t, self._stored


def requested_times(t_out: Sequence[float] | Array, t0: float, t_end: float) -> Array:
    """Check the output times: (k,) ascending without repetition, inside [t0, t_end].

    Parameters
    ----------
    t_out : output times (k,) [s]
    t0 : start of the run [s]
    t_end : end of the run [s]

    Raises
    ------
    ValueError : not so; the message names the offending time
    """
    times = np.asarray(t_out, dtype=float)
    if times.ndim != 1 or times.size == 0:
        raise ValueError(f"t_out: expected a non-empty 1-D array of times, got {t_out!r}")
    backward = np.flatnonzero(~(np.diff(times) > 0))
    if backward.size:
        i = int(backward[0])
        raise ValueError(
            f"t_out: expected strictly ascending times, got {times[i]!r} s followed by "
            f"{times[i + 1]!r} s at position {i + 1}"
        )
    for value in (times[0], times[-1]):
        if not t0 <= value <= t_end:
            raise ValueError(f"t_out: expected times in [{t0!r}, {t_end!r}] s, got {value!r} s")
    return times


MOST_NOTED = 200  # steps noted one by one before they are looked at


class StopRequest(NamedTuple):
    """Ask the run to end at t_stop, inside one of the steps just taken."""

    t_stop: float  # [s]
    message: str
    code: str = ""


# Attempts at steps while a law chatters, after which the run ends if it would need so many more.
SLIDING, TOO_MANY = 20_000, 1_000_000


@record
class Steps:
    """k steps: step i goes from t[i], y[i] to t[i + 1], y[i + 1]."""

    t: Array  # (k + 1,) [s]
    y: Array  # (k + 1, n)
    _stand: Callable[[int], Integrator]
    Z: Array | None = None  # (k, 3, n) changes at the stages of each step, where they are kept
    multipliers: Array | None = None  # (k, 3, n_r) there

    def __len__(self) -> int:
        return self.t.size - 1

    def at(self, i: int) -> Integrator:
        """Return the integrator as it stood after step i.

        A step loop takes the steps up to there again: ask in ascending order.
        """
        return self._stand(i)

    def dense_output(self, i: int) -> Dense:
        """Solution inside step i."""
        return self.at(i).dense_output()

    def step_at(self, t: float) -> int:
        """Return the step in which time t lies; at the end of a step, that step."""
        return int(np.clip(np.searchsorted(self.t, t) - 1, 0, len(self) - 1))

    def until(self, t: float) -> "Steps":
        """Return the steps up to the one in which t lies."""
        last = self.step_at(t) + 2
        return replace(self, t=self.t[:last], y=self.y[:last])


class Watch(Protocol):
    """Looks at the steps of a run as they are taken, and may end it."""

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Look at steps; return the earliest reason to end the run."""

    @property
    def note(self) -> Callable[[float, Array], bool]:
        """Takes notice of a step that ends at t, y (n,), for integrators without strides.

        Returns whether it needs a look now. Without one, up to MOST_NOTED steps are shown together
        later, when only the last of them can be looked into.
        """


class EachStep:
    """Watch that calls a function of the integrator after each step."""

    def __init__(self, on_step: Callable[[Integrator], StopRequest | None]) -> None:
        self._on_step = on_step

    def note(self, t: float, y: Array) -> bool:
        """Every step needs a look."""
        return True

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Show the one step there is."""
        return self._on_step(steps.at(0))


class Noted:
    """Steps of an integrator that takes them one by one, kept to be looked at together."""

    def __init__(self, integrator: Integrator) -> None:
        self._integrator = integrator
        self._t, self._y = np.empty(MOST_NOTED + 1), np.empty((MOST_NOTED + 1, integrator.n))
        self.count = 0
        self._start()

    def _start(self) -> None:
        self._t[0], self._y[0] = self._integrator.t, self._integrator.y
        self.count = 0

    def add(self, t: float, y: Array) -> bool:
        """Keep a step that ends at t, y; return whether there is no room for another."""
        self.count += 1
        self._t[self.count], self._y[self.count] = t, y
        return self.count == MOST_NOTED

    def taken(self) -> Steps:
        """Return the steps kept, and begin again."""
        last = self.count + 1
        steps = Steps(self._t[:last].copy(), self._y[:last].copy(), lambda i: self._integrator)
        self._start()
        return steps


@record
class Solution:
    """The solution of a run.

    A run that ended early keeps the requested times up to there and one more row: the
    state where it ended (t_stop of the request, or the last accepted step).
    """

    t: Array  # (k,) [s]
    y: Array  # (k, n); LongRows (math/rows.py) if they are too many for memory
    status: str  # finished | stopped | failed | interrupted
    message: str
    code: str = ""  # of the stop request
    counters: Counters = field(default_factory=Counters)
    hints: tuple[str, ...] = ()
    stalls: tuple[Stall, ...] = ()
    refusals: Refusals | None = None
    damped_energy: float = 0.0  # taken out of vibrations, as far as the integrator counts it [J]


def integrate(
    integrator: Integrator,
    t_out: Sequence[float] | Array,
    on_step: Callable[[Integrator], StopRequest | None] | None = None,
    *,
    watch: Watch | None = None,
    on_stall: Callable[[Stall], None] | None = None,
    on_chatter: Callable[[int, float], None] | None = None,
    folder: Path | None = None,
) -> Solution:
    """Step to the end; the solution at t_out comes from dense output, not the nearest step.

    Parameters
    ----------
    integrator : fresh or part way; times before its present one must not be asked for
    t_out : (k,) strictly ascending times [s]
    on_step : called after each accepted step; may return a StopRequest. Steps of compiled loops
        are taken one by one for it
    watch : sees all accepted steps, many at a time; may return a StopRequest. The run ends with
        the step that it names; steps beyond are dropped
    on_stall : called at once when a run has come to a stall, and what was done about it
    on_chatter : called at once with the number of an expression that chatters, and its time [s]
    folder : where rows are kept that are too many for memory; None: that of temporary files

    Raises
    ------
    ValueError : t_out, or a stop request outside the steps. Numerical trouble is no
        exception but the status of the solution; neither is Ctrl-C.
    """
    times = requested_times(t_out, integrator.t, integrator.t_end)
    # Of one kind in memory, for a loop that is compiled for it.
    times = np.require(times, requirements=("C", "A", "W"))
    drive = _Drive(integrator, Output(times, integrator.n, folder), on_stall, on_chatter)
    interrupted = False
    try:
        if on_step is not None:
            drive.step_by_step(EachStep(on_step))
        elif integrator.strides:
            drive.by_strides(watch)
        else:
            drive.step_by_step(watch)
    except KeyboardInterrupt:
        interrupted = True
    return drive.solution(interrupted)


class _Drive:
    """A run under way: what is kept of it."""

    def __init__(
        self,
        integrator: Any,
        output: Output,
        on_stall: Callable[[Stall], None] | None,
        on_chatter: Callable[[int, float], None] | None,
    ) -> None:
        self.integrator, self.output = integrator, output
        self.t_last, self.y_last = integrator.t, integrator.y
        self.request: StopRequest | None = None
        pace = Pace(integrator.t, integrator.t_end, output.times)
        self._pace, self._on_stall, self._on_chatter = pace, on_stall, on_chatter
        self._slides: list[tuple[float, int]] = []  # laws that chatter: since when, attempts
        if output.times[0] == self.t_last:
            output.rows[0] = self.y_last
            output.filled = 1

    def by_strides(self, watch: Watch | None) -> None:
        """Let the integrator's own loop run, many steps in one call."""
        integrator, output = self.integrator, self.output
        keep = watch is not None or output.in_parts
        try:
            while integrator.status == "running" and self.request is None:
                filled = integrator.stride(output.window, output.rows, output.filled, keep)
                if integrator.t >= output.next_time:
                    # Steps that the window has no room for are taken again.
                    steps = integrator.steps_taken()
                    integrator.take_back(steps.step_at(output.next_time))
                if watch is not None:
                    self._show(watch, integrator.steps_taken(), filled)
                if self.request is None:
                    self._reach(integrator.t, integrator.y, filled)
                    output.make_room()
                    self._follow()
        except KeyboardInterrupt:
            # Accepted steps are kept, also those that were not processed yet. Plain NumPy is
            # interrupted within a stride: the state is that of the end of the last one.
            integrator.take_up()
            filled = int(np.searchsorted(output.window, integrator.t, side="right"))
            self._reach(integrator.t, integrator.y, max(output.filled, filled))
            raise

    def step_by_step(self, watch: Watch | None) -> None:
        """Take the steps one by one."""
        integrator, output = self.integrator, self.output
        noted = None if watch is None else Noted(integrator)
        while integrator.status == "running" and self.request is None:
            integrator.step()
            t, y = integrator.t, integrator.y
            if t == self.t_last:
                break
            if watch is not None and noted is not None:
                full, doubt = noted.add(t, y), watch.note(t, y)
                if full or doubt:
                    self.request = watch(noted.taken())
            if self.request is not None:
                t = _inside(self.request, integrator)
                y = _values(integrator, np.array([t]))[0]
            while True:
                filled = output.filled
                stop = int(np.searchsorted(output.window, t, side="right"))
                if stop > filled:
                    output.rows[filled:stop] = _values(integrator, output.window[filled:stop])
                self._reach(t, y, max(stop, filled))
                if output.next_time > t:
                    break
                output.make_room()
            self._follow()
        if watch is not None and noted is not None and noted.count:
            watch(noted.taken())

    def _follow(self) -> None:
        """Let the integrator look at its pace, unless its steps are fixed."""
        integrator, known = self.integrator, list(self.integrator.stalls)
        if integrator.status == "running" and integrator.fixed_step is None:
            integrator.follow(self._pace)
            if self._on_stall is not None and integrator.stalls != known:
                self._on_stall(integrator.stalls[-1])
            self._slide()

    def _slide(self) -> None:
        """Say that a law has begun to chatter; end a run that would grind on because of it."""
        integrator, counters = self.integrator, self.integrator.counters
        attempts = counters.steps + counters.rejected
        for program, t in list(integrator.chattering.items())[len(self._slides) :]:
            self._slides.append((t, attempts))
            if self._on_chatter is not None:
                self._on_chatter(program, t)
        since, begin = self._slides[0] if self._slides else (0.0, attempts)
        taken, gone = attempts - begin, integrator.t - since
        if taken > SLIDING and (integrator.t_end - integrator.t) * taken > TOO_MANY * gone:
            text = (
                f"The run was ended at t = {integrator.t:.9g} s: since t = {since:.6g} s it has "
                f"taken {taken} attempts at steps for {gone:.2g} s; expected fewer than "
                f"{TOO_MANY:,} to its end"
            )
            self.request = StopRequest(integrator.t, text, "law-chatters")

    def _reach(self, t: float, y: Array, filled: int) -> None:
        self.t_last, self.y_last, self.output.filled = t, y, filled

    def _show(self, watch: Watch, steps: Steps, filled: int) -> None:
        """Show the steps of a stride; end the run in the step in which a request lies."""
        if len(steps) == 0:
            return
        self.request = watch(steps)
        if self.request is None:
            self.integrator.take_up()
            return
        integrator, output = steps.at(steps.step_at(self.request.t_stop)), self.output
        t = _inside(self.request, integrator)
        self._reach(t, _values(integrator, np.array([t]))[0], filled)
        output.cut(int(np.searchsorted(output.times[: output.count], t, side="right")))

    def solution(self, interrupted: bool) -> Solution:
        """Return the solution of the run."""
        integrator, output = self.integrator, self.output
        status, message, code = integrator.status, integrator.message, ""
        if interrupted:
            status = "interrupted"
            message = f"Interrupted at t = {self.t_last:.9g} s; kept up to there"
        elif self.request is not None:
            status, message, code = "stopped", self.request.message, self.request.code
        if interrupted or self.request is not None or status != "finished":
            output.cut(int(np.searchsorted(output.times[: output.count], self.t_last, "right")))
        reached = output.count > 0 and output.times[output.count - 1] >= self.t_last
        more = () if status == "finished" or reached else ((self.t_last, self.y_last),)
        t, y = output.all(*more)
        return Solution(
            t=t,
            y=y,
            status=status,
            message=message,
            code=code,
            counters=integrator.counters,
            hints=tuple(integrator.hints) if interrupted else integrator.final_hints(),
            stalls=tuple(integrator.stalls),
            refusals=integrator.refusals(),
            damped_energy=integrator.damped_energy,
        )


def _values(integrator: Integrator, times: Array) -> Array:
    """Solution at times (k,) inside the last step, (k, n); exact at its end."""
    if times.size == 1 and times[0] == integrator.t:
        return integrator.y[None, :].copy()
    values = integrator.dense_output()(times)
    if times[-1] == integrator.t:
        values[-1] = integrator.y
    return values


def _inside(request: StopRequest, integrator: Integrator) -> float:
    if not integrator.t_old <= request.t_stop <= integrator.t:
        raise ValueError(
            f"t_stop: expected a time in the last step [{integrator.t_old!r}, {integrator.t!r}] s, "
            f"got {request.t_stop!r} s"
        )
    return request.t_stop
