"""Friction of Coulomb with Stribeck's effect, regularised near rest."""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from .bearing import BY_REACTION, COEFFICIENT, by_reaction, contact, slip
from .contract import CoordinateForce, Number, Terms

COULOMB = Number(
    "coulomb",
    "N or N m",
    "friction of fast sliding that does not depend on the reaction; it or `coefficient`",
    default=0.0,
    least=0.0,
)
STATIC = Number(
    "static", "N or N m", "friction at the onset of sliding; absent: `coulomb`", least=0.0
)
STRIBECK = Number(
    "stribeck_velocity",
    "m/s or rad/s",
    "over which friction falls from `static` to `coulomb`, from `static_coefficient` to "
    "`coefficient`; absent only where they are equal",
    above=0.0,
)
VISCOUS = Number(
    "viscous", "N s/m or N m s/rad", "coefficient of viscous friction", default=0.0, least=0.0
)
# Keys of all kinds of friction.
SLIDING = (COULOMB, STATIC, *BY_REACTION, STRIBECK, VISCOUS)


def sliding(values: Mapping[str, Any], load: str, speed: str = "v") -> str:
    """Return the friction of steady sliding as an expression [N, N m].

    Parameters
    ----------
    values : numbers of the element by key
    load : normal force of the contact, as an expression
    speed : sliding velocity, as an expression
    """
    parts, falls = [], []
    by_load = f" * ({load})"
    for low, high, of in (
        ("coulomb", "static", ""),
        (COEFFICIENT, "static_coefficient", by_load),
    ):
        slow, fast = values[high], values[low] or 0.0
        if not (fast or slow):
            continue
        parts.append(f"{low}{of}")
        if slow is None or slow == fast:
            continue
        if slow < fast:
            raise InputError(f".{high} = {slow:g}: expected {low} = {fast:g} or above")
        falls.append(f"({high} - {low}){of}")
    if falls and values["stribeck_velocity"] is None:
        raise InputError(
            ".stribeck_velocity: missing; expected the speed over which friction falls"
        )
    if falls:
        parts.append(f"({' + '.join(falls)}) * exp(-({speed} / stribeck_velocity) ** 2)")
    return " + ".join(parts)


def _terms(values: Mapping[str, Any]) -> Terms:
    load = contact(values) if by_reaction(values) else "0"
    if not (values["coulomb"] or values["static"] or values[COEFFICIENT]):
        raise InputError(": has no effect; expected coulomb or coefficient above 0")
    speed = slip(values)
    if not speed:
        return Terms(f"-({sliding(values, load)}) * tanh(v / rest_velocity) - viscous * v")
    whole = f"({sliding(values, load, 'slip')}) * tanh(slip / rest_velocity)"
    return Terms(f"-{whole} * v / slip - viscous * v", names={"slip": speed})


FRICTION = CoordinateForce(
    kind="friction",
    meaning="friction of Coulomb and Stribeck",
    remark="-(coulomb + (static - coulomb) exp(-(v/stribeck_velocity)^2)) tanh(v/rest_velocity) "
    "- viscous v. At rest it creeps: below `rest_velocity` it is a damper. `bristle_friction` "
    "sticks. With `coefficient` it grows with the reaction of the joint, see friction.md.",
    keys=(
        *SLIDING,
        Number(
            "rest_velocity",
            "m/s or rad/s",
            "speed below which the direction of sliding is smoothed",
            required=True,
            above=0.0,
        ),
    ),
    terms=_terms,
    order=7,
    steep="a larger rest_velocity, at least rtol times the velocities of the motion, or kind "
    "bristle_friction instead",
)
