"""Stop: a contact that keeps a coordinate between limits, by the law of Hunt and Crossley.

K. H. Hunt and F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact,
J. Appl. Mech. 42 (1975) 440-445: F = k d^n (1 + b ddot) at the depth d. The force begins and ends
at zero, so that the error control of an integrator resolves the contact. A mass that hits at the
speed u leaves at e u with, for any n, the solution of the equation of motion

    a (1 + e) = log((1 + a) / (1 - a e)),   a = b u.

Without a given u, b = a / u follows the speed of each impact: an auxiliary state takes it at the
instant at which the coordinate passes the limit, which is located as an event.
"""

from collections.abc import Mapping
from math import log1p
from typing import Any

from ....errors import InputError
from ...tolerances import FULL_RESTITUTION, SLOWEST_IMPACT
from .contract import CoordinateForce, Number, State, Terms

# A contact in which a run begins had no impact: it takes the speed of a fall through its depth.
FALL = 2.0 * 9.81


def damping(restitution: float) -> float:
    """Return a = b u of a restitution e, 0 < e <= 1."""
    e = restitution
    if e >= FULL_RESTITUTION:
        return 0.0

    def missing(a: float) -> float:
        return a * (1.0 + e) - log1p(a) + log1p(-a * e)

    # above 0 near a = 0, where it grows as a^2 (1 - e^2) / 2; towards -inf at a = 1 / e
    below, above = 1e-3 * (1.0 - e), (1.0 - 1e-12) / e
    while missing(above) > 0.0:  # a e = 1 to rounding
        return above
    for _ in range(200):
        middle = 0.5 * (below + above)
        if missing(middle) > 0.0:
            below = middle
        else:
            above = middle
    return below


def _terms(values: Mapping[str, Any]) -> Terms:
    lower, upper = values["lower"], values["upper"]
    if lower is None and upper is None:
        raise InputError(": has no effect; expected lower or upper")
    if lower is not None and upper is not None and not lower < upper:
        raise InputError(f".lower = {lower:g}: expected below upper = {upper:g}")
    e, speed = values["restitution"], values["impact_speed"]
    ratio, states = (damping(e) if e < 1.0 else 0.0), []
    parts = []
    for end, limit, sign, depth, rate in (
        ("upper", upper, "-", "x - upper", "v"),
        ("lower", lower, "", "lower - x", "-v"),
    ):
        if limit is None:
            continue
        u = f"{end}_speed" if speed is None else repr(speed)
        if speed is None and ratio:
            hit = f"max(abs(v), {SLOWEST_IMPACT!r})"
            start = f"hypot({hit}, sqrt({FALL!r} * max({sign or '+'}({limit!r} - x), 0)))"
            states.append(
                State(u, None, start=start, update=hit, level=limit, upwards=end == "upper")
            )
        harder = f"max(1 + {ratio!r} * ({rate}) / {u}, 0)" if ratio else "1"
        parts.append(f"{sign}stiffness * max({depth}, 0) ** exponent * {harder}")
    return Terms(" + ".join(parts), states=tuple(states))


LIMIT_STOP = CoordinateForce(
    kind="limit_stop",
    turns=False,
    meaning="a contact that keeps a coordinate between limits",
    remark="The law of Hunt and Crossley, k d^n (1 + b ddot) at the depth d. Without "
    "`impact_speed`, the instant of each impact is located, and b follows its speed. With it, b is "
    "constant: a slower impact loses less than `restitution` says, a faster one more.",
    keys=(
        Number("lower", "m or rad", "limit of the coordinate; absent: none"),
        Number("upper", "m or rad", "limit of the coordinate; absent: none"),
        Number("stiffness", "N/m^n or N m/rad^n", "k", required=True, above=0.0),
        Number("exponent", "", "n; 1.5: Hertz", default=1.5, least=1.0, most=3.0),
        Number(
            "restitution",
            "",
            "speed after an impact over that before it",
            default=1.0,
            above=0.0,
            most=1.0,
        ),
        Number(
            "impact_speed",
            "m/s or rad/s",
            "speed for which `restitution` holds; absent: it holds for every impact",
            above=0.0,
        ),
    ),
    terms=_terms,
    order=6,
)
