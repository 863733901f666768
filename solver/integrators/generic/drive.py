"""Run an integrator to its end and keep the solution at requested times."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...math.arrays import Array
from .base import Counters, Integrator


@dataclass(frozen=True)
class StopRequest:
    """Ask the run to end inside the step just taken, at t_stop in [t_old, t]."""

    t_stop: float  # [s]
    message: str
    code: str = ""


@dataclass(frozen=True)
class Solution:
    """What a run leaves behind.

    A run that ended early keeps the requested times up to there and one more row: the
    state where it ended (t_stop of the request, or the last accepted step).
    """

    t: Array  # (k,) [s]
    y: Array  # (k, n)
    status: str  # finished | stopped | failed | interrupted
    message: str
    code: str = ""  # of the stop request
    counters: Counters = field(default_factory=Counters)
    hints: tuple[str, ...] = ()


def requested_times(t_out: Sequence[float] | Array, t0: float, t_end: float) -> Array:
    """Check the output times: (k,) ascending without repetition, inside [t0, t_end].

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


def integrate(
    integrator: Integrator,
    t_out: Sequence[float] | Array,
    on_step: Callable[[Integrator], StopRequest | None] | None = None,
) -> Solution:
    """Step to the end; the solution at t_out comes from dense output, not the nearest step.

    Parameters
    ----------
    integrator : fresh or part way; times before its present one must not be asked for
    t_out : (k,) strictly ascending times [s]
    on_step : called after each accepted step; may return a StopRequest

    Raises
    ------
    ValueError : t_out, or a stop request outside the step. Numerical trouble is no
        exception but the status of the solution; neither is Ctrl-C.
    """
    times = requested_times(t_out, integrator.t, integrator.t_end)
    rows: list[Array] = []
    t_last, y_last = integrator.t, integrator.y
    if times[0] == t_last:
        rows.append(y_last.copy())
    request: StopRequest | None = None
    interrupted = False
    try:
        if integrator.strides and on_step is None:
            try:
                _stride(integrator, times, rows)
            finally:
                t_last, y_last = integrator.t, integrator.y
        while integrator.status == "running":
            integrator.step()
            if integrator.t == t_last:
                break
            if on_step is not None:
                request = on_step(integrator)
            t_known = integrator.t if request is None else _inside(request, integrator)
            stop = int(np.searchsorted(times, t_known, side="right"))
            if stop > len(rows):
                rows.extend(_values(integrator, times[len(rows) : stop]))
            t_last, y_last = integrator.t, integrator.y
            if request is not None:
                t_last, y_last = t_known, _values(integrator, np.array([t_known]))[0]
                break
    except KeyboardInterrupt:
        interrupted = True
    kept = times[: len(rows)]
    status, message, code = integrator.status, integrator.message, ""
    if interrupted:
        status, message = "interrupted", f"Interrupted at t = {t_last:.9g} s; kept up to there"
    elif request is not None:
        status, message, code = "stopped", request.message, request.code
    if status != "finished" and (kept.size == 0 or kept[-1] < t_last):
        kept = np.append(kept, t_last)
        rows.append(y_last)
    return Solution(
        t=kept,
        y=np.array(rows).reshape(kept.size, integrator.n),
        status=status,
        message=message,
        code=code,
        counters=integrator.counters,
        hints=tuple(integrator.hints) if interrupted else integrator.final_hints(),
    )


def _stride(integrator: Any, times: Array, rows: list[Array]) -> None:
    """Let the integrator's own loop run; add the rows it reaches."""
    times = times.copy()  # of one kind in memory, for a loop that is compiled for it
    values = np.empty((times.size, integrator.n))
    filled = len(rows)
    for k, row in enumerate(rows):
        values[k] = row
    try:
        while integrator.status == "running":
            filled = integrator.stride(times, values, filled)
    finally:
        rows[:] = list(values[:filled])


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
