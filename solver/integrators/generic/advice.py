"""Stalls and refused attempts of a run, and messages about runs that fail or cost too much."""

from collections.abc import Callable
from math import isfinite
from typing import NamedTuple

import numpy as np

from ...math.arrays import Array

SLOW = 100  # steps of one interval of the results, at this pace
INTERVALS = 1000  # a run has at least so many, however few are asked for
WINDOW = 2000  # attempts between two looks
OWN = 0.01  # step times rate of a motion, from which on the motion itself asks for such steps


class Stall(NamedTuple):
    """A stretch of a run with tiny steps, and what was done about it."""

    t: float  # when it was noticed [s]
    step: float  # average [s]
    refused: float  # share of the attempts
    component: int  # of the state, which keeps the steps short: of the fastest motion
    rate: float  # of that motion [rad/s]; 0: unknown
    cutoff: float = 0.0  # above which vibrations are damped from then on [rad/s]; 0: none
    remedy: str = ""  # what a user can do


class Refusals(NamedTuple):
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
        """Look at a run at t [s] after so many steps; None where it goes on well, or too early.

        Parameters
        ----------
        t : time [s]
        steps : accepted steps of the run so far
        refused : refused attempts so far
        """
        attempts = steps + refused - self._attempts
        if attempts < WINDOW:
            return None
        turned_down = refused - self._refused
        mean = float(t - self._t) / max(attempts - turned_down, 1)
        self._t, self._attempts, self._refused = t, steps + refused, refused
        if mean * SLOW >= self.interval:
            return None
        return Stall(float(t), mean, turned_down / attempts, -1, 0.0)


HIGHEST_RADIUS = 0.95  # with index 3 (docs/pictures/stability.png)
FEEDBACK_LIMITED = 0.06  # rate times mean step, over the order of the method
STEPS_WORTH_A_LOOK = 100
GROWN = 1e3

SHORTER = "error control (no fixed step) shortens it by itself"
WANTED = "If it is the motion that is wanted, an output_step that shows it"
STALLED = (
    "radau, or gear with max_order = 2, which damp vibrations of no interest, or rk8 where nothing "
    f"vibrates; a larger rtol, fewer modes, or damping of the body or element. {WANTED}"
)
NOT_FINITE = "Look for a singular position, a division by zero or unstable motion just after it"
OTHERWISE = (
    "Look for a jump or a singularity in the forces just after it, loosen rtol "
    "and atol, or use an implicit method if the problem is stiff"
)
IMPLICIT = (
    "Look for a jump or a singularity in the forces just after it, or for constraints that "
    "contradict each other, or increase rtol"
)


def of_choice(formulation: str, rho: float) -> list[str]:
    """Remarks on options of generalized-alpha that are known to disappoint."""
    if formulation == "index3" and rho > HIGHEST_RADIUS:
        return [
            f'undamped: spectral_radius = {rho:g} with constraints = "index3" damps too little: '
            "multipliers and the velocities that the constraints forbid swing from step to step; "
            'spectral_radius = 0.8 or constraints = "ggl" settles them'
        ]
    return []


def of_feedback(rate: float, h_mean: float, order: int) -> list[str]:
    """Remarks on a run of mean step `h_mean` [s] whose constraints are fed back at `rate` [1/s].

    Parameters
    ----------
    rate : feedback of the constraints [1/s]
    h_mean : mean step size [s]
    order : order of the method
    """
    if rate * h_mean < FEEDBACK_LIMITED * order:
        return []
    return [
        f"feedback: the steps average {h_mean:.3g} s, as short as the feedback of the constraints "
        f"({rate:.3g} 1/s) asks for: smaller alpha and beta (frequency), or constraints = "
        '"projection", which has no rate of its own, allow longer ones'
    ]


def of_stability(h_mean: float, rate: float) -> str:
    """Remark on a run of mean step `h_mean` [s] that stability has kept short of 1 / `rate`."""
    return (
        f"stability: the steps average {h_mean:.3g} s, and the fastest motion has a rate of "
        f"{rate:.3g} 1/s ({rate / 2 / np.pi:.3g} Hz): longer steps would be unstable, not "
        "inaccurate; if that motion is of no interest, an implicit method (radau, "
        "generalized-alpha, or gear with max_order = 2) or fewer modes need fewer steps"
    )


ITERATIONS = 12
RATE_EVALUATIONS = 2 * ITERATIONS + 1


class Motion(NamedTuple):
    """The fastest motion about a state."""

    rate: float  # largest modulus of the eigenvalues of df/dy [1/s]
    component: int  # of the state, which moves most; -1: none moves
    direction: complex  # of the eigenvalue, of modulus one; imaginary part >= 0


def fastest_motion(f: Callable[[float, Array], Array], t: float, y: Array, weight: Array) -> Motion:
    """Return the fastest motion, by power iteration on differences of f.

    Two applications at a time: a pair of imaginary eigenvalues +-iw gives -w^2. The direction is
    that of the largest of two eigenvalues, by least squares.
    `weight` (n,) scales the components, 0 leaves one out; RATE_EVALUATIONS evaluations.

    Parameters
    ----------
    f : right-hand side of y' = f(t, y)
    t : time [s]
    y : state (n,)
    weight : scale of the components (n,), 0 leaves one out
    """
    known = np.isfinite(weight) & (weight > 0)
    scale = np.where(known, weight, 0.0)
    size = np.divide(1.0, scale, out=np.zeros_like(scale), where=known)
    f_y = np.array(f(t, y))

    def applied(z: Array) -> Array:
        small = 10.0 / float(np.linalg.norm(z))  # ten tolerances
        change: Array = (f(t, y + small * size * z) - f_y) * scale / small
        return change

    z = np.cos(np.arange(y.size, dtype=float)) * known
    square = 0.0
    for _ in range(ITERATIONS):
        before = z / np.linalg.norm(z)
        once = applied(before)
        if not np.any(once):
            return Motion(0.0, -1, 1j)
        z = applied(once)
        square = float(np.linalg.norm(z))
        if not (isfinite(square) and square > 0):
            return Motion(0.0, -1, 1j)
    # the two eigenvalues in whose plane J z lies: J^2 z - p J z + q z = 0
    (p, q), *_ = np.linalg.lstsq(np.column_stack((once, -before)), z, rcond=None)
    largest = max(np.roots([1.0, -p, q]), key=abs)
    direction = complex(largest.real, abs(largest.imag)) / abs(largest)
    return Motion(square**0.5, int(np.argmax(np.abs(z))), direction)
