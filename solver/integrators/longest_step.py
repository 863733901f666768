"""The longest step that loads of short duration leave to an integrator."""

import numpy as np

from ..dynamics.model import Model
from ..math.expressions.operations import TIME

# A step that begins and ends at rest tells nothing of a pulse between its stages: the error
# estimate is zero, and so is the reason to make the step shorter.
PIECES = 3  # of a smooth step, which remains and is therefore seen
MOST_STEPS = 2000  # that the pieces of a table may cost
EXPRESSION = 200  # steps at least where an expression reads the time: its pulses are not known


def longest_step(model: Model, t_end: float) -> float:
    """Return the largest step [s] with which no pulse of a table is stepped over; or infinity.

    It is the shortest piece of the tables of drives, loads and actuators, and `t_end / EXPRESSION`
    where an expression reads the time, other than at the instants of a sampled controller.
    """
    longest = t_end / EXPRESSION if _reads_time(model) else np.inf
    for law in range(len(model.law_start) - 1):
        times = model.law_time[model.law_start[law] : model.law_start[law + 1]]
        if len(times) > PIECES:
            within = times[times <= t_end]
            shortest = float(np.diff(within).min(initial=np.inf))
            longest = min(longest, max(shortest, t_end / MOST_STEPS))
    return longest


def _reads_time(model: Model) -> bool:
    """Whether an expression of a law, force or rate has the time in it."""
    read = model.quantities
    used = np.concatenate([read.law, read.force, read.rate])
    start, code = read.programs.start, read.programs.code
    return any(TIME in code[start[p] : start[p + 1]] for p in used[used >= 0])
