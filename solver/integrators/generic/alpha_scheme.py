"""Coefficients and step control of generalized-alpha."""

from typing import NamedTuple

from ...errors import did_you_mean
from ...math.compiled import structure

FORMULATIONS = ("ggl", "index3")
SPECTRAL_RADIUS = 0.8  # at infinity, by default
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 2.0
HYSTERESIS = 1.2  # a change of step disturbs index 3: not for less than this
MAX_ITERATIONS = 8
TOLERANCE = 0.05  # of the local error allowed, left over by Newton's iteration


@structure
class Scheme(NamedTuple):
    """Coefficients for one spectral radius rho at infinity."""

    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float
    to_v: float  # z enters the velocity at the end times this over h
    to_a: float  # and the acceleration times this over h^2
    error_q: float  # local error of positions [h^3 vddot]
    error_v: float  # and velocities [h^3 vdddot]
    stabilised: bool  # ggl: positions and velocities both satisfy their constraints


def check_formulation(formulation: str, possible: tuple[str, ...] = FORMULATIONS) -> None:
    """Raise ValueError for a formulation that is not among the possible ones."""
    if formulation not in possible:
        raise ValueError(
            f"formulation: expected one of {', '.join(possible)}, got {formulation!r}"
            f"{did_you_mean(formulation, possible)}"
        )


def scheme(formulation: str, rho: float) -> Scheme:
    """Return the scheme of spectral radius rho, 0 to 1 (integrators/generalized_alpha.py).

    Raises
    ------
    ValueError : another formulation or spectral radius; the message names it
    """
    check_formulation(formulation)
    if not 0.0 <= rho <= 1.0:
        raise ValueError(f"spectral_radius: expected a number from 0 to 1, got {rho!r}")
    rho = float(rho)
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    lag = alpha_m - alpha_f
    gamma = 0.5 - lag
    beta = 0.25 * (gamma + 0.5) ** 2
    return Scheme(
        alpha_m,
        alpha_f,
        gamma,
        beta,
        gamma / beta,
        (1 - alpha_m) / (beta * (1 - alpha_f)),
        abs(beta + 0.5 * lag - 1 / 6),
        abs(1 / 12 - 0.5 * lag * lag),
        formulation == "ggl",
    )
