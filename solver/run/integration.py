"""Integration of a prepared mechanism, and of the other runs that its signals read."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..checks.finished import FinishedRun, Look
from ..inputs.case.record import needed
from ..integrators.choice import make_integrator
from ..integrators.generic.advice import Stall
from ..integrators.generic.drive import Watch, integrate
from ..math.arrays import Array
from ..results.codes import BREAKS_UNSEARCHED, Finding
from ..signals import Histories, recorded
from .outcome import RunSpec
from .preparation import Prepared, prepare

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import Signal as SignalTable

# Integration of a prepared mechanism over its output times.


def output_times(t_end: float, step: float) -> Array:
    """Return 0, step, 2 step, ..., t_end, (k,) [s]; the last interval may be shorter."""
    count = int(np.floor(t_end / step * (1 + 1e-12)))
    times = np.linspace(0.0, count * step, count + 1)
    if t_end - times[-1] > 1e-9 * t_end:
        times = np.append(times, t_end)
    times[-1] = t_end
    return times


def integrated(
    prepared: Prepared,
    watch: Watch | None = None,
    look: Look | None = None,
    on_stall: Callable[[Stall], None] | None = None,
    folder: Path | None = None,
) -> FinishedRun:
    """Integrate a prepared mechanism from its start to `t_end`: a single run, or one of a sweep.

    Numerical trouble and Ctrl-C while it steps are no exceptions but the status of the solution.

    Parameters
    ----------
    watch : sees the steps in place of the monitors, which it must call itself
    look : at how many output times the checks look
    on_stall : told at once of a run that has come to a stall
    folder : for states that are too many for memory; None: that of temporary files
    """
    solver = prepared.mechanism.solver
    solution, order = prepared.refused, 0
    if solution is None:
        integrator = make_integrator(
            prepared.model,
            prepared.y0,
            solver,
            prepared.treatment,
            functions=prepared.functions,
        )
        if integrator.unsearched:
            prepared.notes.append(_unsearched(integrator.unsearched))
        times = output_times(solver.t_end, solver.output_step)
        prepared.turns.times = times
        solution = integrate(
            integrator,
            times,
            watch=watch or prepared.watch,
            on_stall=on_stall,
            folder=folder,
        )
        if integrator.most_hidden <= 0:
            prepared.notes.append(_unseen(type(integrator).most_hidden))
        order = integrator.order
    return prepared.finished(prepared.explained(solution), order, look or Look())


def _unsearched(count: int) -> Finding:
    text = (
        f"{count} of the expressions of the time may break at more than 50,000 instants: no step "
        "ends there, and short pulses may be stepped over; write the breaks as a table, give "
        "`max_step`, or a shorter `t_end`"
    )
    return BREAKS_UNSEARCHED.finding(text, value=count)


def _unseen(count: int) -> Finding:
    text = (
        f"a force by an expression varied unseen inside of {count} steps, which then ended there; "
        "later ones do not, and narrow forces may be stepped over: give `max_step`, or a smaller "
        "rtol"
    )
    return replace(BREAKS_UNSEARCHED.finding(text, value=count), limit=float(count))


def complete(prepared: Prepared) -> FinishedRun:
    """Integrate a run that serves another purpose than its own results: a part of it is no use.

    Raises
    ------
    KeyboardInterrupt
        A signal has ended it. `integrated` keeps its part.
    """
    finished = integrated(prepared)
    if finished.solution.status == "interrupted":
        raise KeyboardInterrupt
    return finished


# Other runs that the combined signals of a run read: they are integrated with it.


def histories_of(
    signals: Mapping[str, "SignalTable"],
    runs: Mapping[str, RunSpec],
    *,
    allow_python: bool = False,
) -> Histories:
    """Return times and signals of the other runs that signals read.

    A run that ends early has fewer times.

    Parameters
    ----------
    signals : of a case; those of them that are combined
    runs : the other runs by name

    Raises
    ------
    InputError
        As `prepare`, of another run.
    """
    found: dict[str, tuple[Array, dict[str, Array]]] = {}
    for run, names in needed(signals).items():
        other = runs[run]
        prepared = prepare(other.mechanism, other.packages, names, allow_python=allow_python)
        finished = complete(prepared)
        recordings = recorded(prepared.measured, finished.model, finished.blocks)
        blocks = [(recording, dict(rows)) for recording, rows in recordings]
        values = {name: np.concatenate([v[name] for _, v in blocks]) for name in names}
        found[run] = np.concatenate([r.t for r, _ in blocks]), values
    return found
