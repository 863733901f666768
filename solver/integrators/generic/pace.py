"""How a run goes on: steps tiny beside what is asked of it (a stall), and attempts refused."""

from dataclasses import dataclass

from ...math.arrays import Array

SLOW = 100  # steps of one interval of the results, at this pace
INTERVALS = 1000  # a run has at least so many, however few are asked for
WINDOW = 2000  # attempts between two looks
OWN = 0.01  # step times rate of a motion, from which on the motion itself asks for such steps


@dataclass(frozen=True)
class Stall:
    """A stretch of a run with tiny steps, and what was done about it."""

    t: float  # when it was noticed [s]
    step: float  # average [s]
    refused: float  # share of the attempts
    component: int  # of the state, which keeps the steps short: of the fastest motion
    rate: float  # of that motion [rad/s]; 0: unknown
    cutoff: float = 0.0  # above which vibrations are damped from then on [rad/s]; 0: none
    remedy: str = ""  # what a user can do


@dataclass(frozen=True)
class Refusals:
    """Attempts of a run that were refused, and why, as far as the integrator knows."""

    attempts: int
    refused: int
    step: float  # accepted, on average [s]
    newton: int = 0  # by an iteration that did not converge
    rough: int = 0  # by the estimate of the error
    component: int = -1  # of the state, which was most often the reason

    @property
    def share(self) -> float:
        """Of the attempts, 0 to 1."""
        return self.refused / self.attempts if self.attempts else 0.0


class Pace:
    """Average step of the last attempts, beside the interval of the results.

    Parameters
    ----------
    t, t_end : time and end of the run [s]
    times : (k,) of the results [s]
    """

    def __init__(self, t: float, t_end: float, times: Array) -> None:
        asked = float(times[-1] - times[0]) / (times.size - 1) if times.size > 1 else t_end - t
        self.interval = min(asked, (t_end - t) / INTERVALS)
        self._t, self._attempts, self._refused = t, 0, 0

    def stalled(self, t: float, steps: int, refused: int) -> Stall | None:
        """Look at a run at t [s] after so many steps; None where it goes on well, or too early."""
        attempts = steps + refused - self._attempts
        if attempts < WINDOW:
            return None
        turned_down = refused - self._refused
        mean = float(t - self._t) / max(attempts - turned_down, 1)
        self._t, self._attempts, self._refused = t, steps + refused, refused
        if mean * SLOW >= self.interval:
            return None
        return Stall(float(t), mean, turned_down / attempts, -1, 0.0)
