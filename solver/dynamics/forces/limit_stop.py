"""Stop: a contact that keeps a coordinate between limits, by the law of Hunt and Crossley.

K. H. Hunt and F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact,
J. Appl. Mech. 42 (1975) 440-445: F = k d^n (1 + b ddot) at the depth d. The force begins and ends
at zero, so that the error control of an integrator resolves the contact. A mass that hits at the
speed u leaves at e u with, for any n, the solution of the equation of motion

    a (1 + e) = log((1 + a) / (1 - a e)),   a = b u.
"""

from collections.abc import Mapping
from math import log1p
from typing import Any

from ...errors import InputError
from .contract import CoordinateForce, Number, Terms


def damping(restitution: float) -> float:
    """Return a = b u of a restitution e, 0 < e <= 1."""
    e = restitution
    if e >= 1.0 - 1e-9:
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
    if e < 1.0 and speed is None:
        raise InputError(
            ".impact_speed: missing; expected the speed of an impact with this restitution"
        )
    b = damping(e) / speed if e < 1.0 else 0.0
    parts = []
    if upper is not None:
        parts.append(f"-stiffness * max(x - upper, 0) ** exponent * max(1 + {b!r} * v, 0)")
    if lower is not None:
        parts.append(f"stiffness * max(lower - x, 0) ** exponent * max(1 - {b!r} * v, 0)")
    return Terms(" + ".join(parts))


LIMIT_STOP = CoordinateForce(
    kind="limit_stop",
    meaning="a contact that keeps a coordinate between limits",
    remark="The law of Hunt and Crossley, k d^n (1 + b ddot) at the depth d. An impact that is "
    "slower than `impact_speed` loses less than its `restitution` says, a faster one more.",
    keys=(
        Number("lower", "m or rad", "limit of the coordinate; absent: none"),
        Number("upper", "m or rad", "limit of the coordinate; absent: none"),
        Number("stiffness", "N/m^n or N m/rad^n", "k", required=True, above=0.0),
        Number("exponent", "", "n; 1.5: Hertz", default=1.5, least=1.0, most=3.0),
        Number(
            "restitution",
            "",
            "speed after an impact of `impact_speed` over that before it",
            default=1.0,
            above=0.0,
            most=1.0,
        ),
        Number(
            "impact_speed",
            "m/s or rad/s",
            "see `restitution`; absent only where that is 1",
            above=0.0,
        ),
    ),
    terms=_terms,
    order=6,
)
