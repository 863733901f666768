"""Words for runs that fail, and for runs that another choice would have made cheaper.

What an integrator is, is known here by the name of its class, so that the classes themselves
need no words.
"""

from collections.abc import Callable
from math import isfinite
from typing import Any

import numpy as np

from ...math.arrays import Array

# Of |h w| on average, above which an explicit method's steps are limited by stability.
LIMITED_ABOVE = {"RungeKutta5": 0.8, "RungeKutta8": 2.0, "ScipyDop853": 2.0}
# Of the mean |h w|: BDF of order 3 and above, kept from growing by its error control.
GROWTH_LIMITED = (0.4, 1.0)
HIGHEST_RADIUS = 0.95  # with index 3 (docs/pictures/stability.png)
FEEDBACK_LIMITED = 0.06  # rate times mean step, over the order of the method
STEPS_WORTH_A_LOOK = 100
GROWN = 1e3

SHORTER = "error control (no fixed step) shortens it by itself"
UNDAMPED = (
    "With too little damping (spectral_radius near 1) what the step does not resolve can grow "
    'where the problem is not linear, and with constraints = "index3" the velocities that the '
    'constraints forbid swing on: take spectral_radius = 0.8, constraints = "ggl", or a '
    f"shorter step ({SHORTER})"
)
ON_GROWTH = {
    "Gear": (
        "BDF of order 3 and above amplifies undamped oscillations that the step does not resolve: "
        "take max_order = 2 or radau, which damp all of them, or leave the step to the error "
        "control"
    ),
    "ExplicitRungeKutta": (
        "An explicit method amplifies what is faster than its step: |h w| of the highest mode must "
        "stay below 1.0 (rk5) or 5.9 (rk8), h alpha and h beta of Baumgarte's feedback below 2. "
        f"Take a shorter step ({SHORTER}), an implicit method (radau, generalized-alpha, or gear "
        'with max_order = 2), fewer modes, or constraints = "projection" instead of baumgarte'
    ),
    "GeneralizedAlpha": UNDAMPED,
    "Radau": (
        "Newton's iteration finds no answer for a step this long, or constraints contradict each "
        f"other: take a shorter step ({SHORTER})"
    ),
}
FAIL_BEFORE_GROWTH = {"GeneralizedAlpha": True, "Radau": True}
COMPARISON = (
    "This code is there for comparison: take gear, radau, rk8 or generalized-alpha, which say more "
    "of their trouble"
)
NOT_FINITE = "Look for a singular position, a division by zero or unstable motion just after it"
OTHERWISE = (
    "Look for a jump or a singularity in the forces just after it, loosen rtol "
    "and atol, or use an implicit method if the problem is stiff"
)
OF_RADAU = (
    "Look for a jump or a singularity in the forces just after it, or for constraints that "
    "contradict each other, or loosen rtol and atol"
)


def of_kind(kind: type, table: dict[str, Any]) -> Any:
    """Entry of the nearest class in the line of ancestors of `kind`; None without one."""
    return next((table[c.__name__] for c in kind.__mro__ if c.__name__ in table), None)


def on_failure(kind: type, *, not_finite: bool, fixed_step: bool, growth: float) -> str:
    """What to do about a run that ended as failed, the last full stop left out.

    `growth` is that of the largest component over the first steps'. What generalized-alpha does
    not damp shows in its multipliers, not in the state, until Newton's iteration fails; the state
    of radau does not grow.
    """
    unstable = growth > GROWN or of_kind(kind, FAIL_BEFORE_GROWTH)
    words = of_kind(kind, ON_GROWTH) if fixed_step and unstable else None
    otherwise = of_kind(kind, {"Radau": OF_RADAU}) or OTHERWISE
    words = words or (NOT_FINITE if not_finite else otherwise)
    borrowed = of_kind(kind, {"Peer": COMPARISON})
    return f"{words}. {borrowed}" if borrowed else str(words)


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
    """Remarks on a run of mean step `h_mean` [s] whose constraints are fed back at `rate` [1/s]."""
    if rate * h_mean < FEEDBACK_LIMITED * order:
        return []
    return [
        f"feedback: the steps average {h_mean:.3g} s, as short as the feedback of the constraints "
        f"({rate:.3g} 1/s) asks for: smaller alpha and beta (frequency), or constraints = "
        '"projection", which has no rate of its own, allow longer ones'
    ]


def of_run(
    kind: type,
    max_order: int,
    h_mean: float,
    fastest: Callable[[], float],
) -> list[str]:
    """Remarks on a finished run whose steps stability has kept short.

    `h_mean` is its mean step [s]; `fastest` finds the highest rate of its end [1/s], and is
    called only where it matters.
    """
    limit = of_kind(kind, LIMITED_ABOVE)
    if limit is not None:
        w = fastest()
        if h_mean * w < limit:
            return []
        return [
            f"stability: the steps average {h_mean:.3g} s, and the fastest motion has a rate of "
            f"{w:.3g} 1/s ({w / 2 / np.pi:.3g} Hz): longer steps would be unstable, not "
            "inaccurate; if that motion is of no interest, an implicit method (radau, "
            "generalized-alpha, or gear with max_order = 2) or fewer modes need fewer steps"
        ]
    if kind.__name__ == "Gear" and max_order > 2:
        w = fastest()
        if GROWTH_LIMITED[0] < h_mean * w < GROWTH_LIMITED[1]:
            return [
                f"order: the steps average {h_mean:.3g} s, and the fastest motion has a rate of "
                f"{w:.3g} 1/s ({w / 2 / np.pi:.3g} Hz), which longer steps of order 3 to 5 would "
                "amplify; if that motion is of no interest, radau or max_order = 2 damp it and may "
                "need fewer steps; if it is, rk8 resolves it at less cost"
            ]
    return []


def fastest_rate(
    f: Callable[[float, Array], Array], t: float, y: Array, weight: Array, iterations: int = 12
) -> float:
    """Largest modulus of the eigenvalues of df/dy [1/s], by power iteration on differences.

    Two applications at a time: a pair of imaginary eigenvalues +-iw gives -w^2.
    `weight` (n,) scales the components, 0 leaves one out; 2 `iterations` + 1 evaluations.
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
    for _ in range(iterations):
        once = applied(z / np.linalg.norm(z))
        if not np.any(once):
            return 0.0
        z = applied(once)
        square = float(np.linalg.norm(z))
        if not (isfinite(square) and square > 0):
            return 0.0
    return square**0.5
