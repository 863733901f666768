"""Friction of Coulomb with Stribeck's effect, regularised near rest."""

from collections.abc import Mapping
from typing import Any

from ...errors import InputError
from .contract import CoordinateForce, Number, Terms

COULOMB = Number("coulomb", "N or N m", "friction of fast sliding", required=True, least=0.0)
STATIC = Number(
    "static", "N or N m", "friction at the onset of sliding; absent: `coulomb`", least=0.0
)
STRIBECK = Number(
    "stribeck_velocity",
    "m/s or rad/s",
    "over which friction falls from `static` to `coulomb`; absent only where they are equal",
    above=0.0,
)
VISCOUS = Number(
    "viscous", "N s/m or N m s/rad", "coefficient of viscous friction", default=0.0, least=0.0
)


def sliding(values: Mapping[str, Any]) -> str:
    """Return the friction of steady sliding at the rate v as an expression [N, N m]."""
    coulomb, static = values["coulomb"], values["static"]
    if static is None or static == coulomb:
        return "coulomb"
    if static < coulomb:
        raise InputError(f".static = {static:g}: expected coulomb = {coulomb:g} or above")
    if values["stribeck_velocity"] is None:
        raise InputError(
            ".stribeck_velocity: missing; expected the speed over which friction falls"
        )
    return "coulomb + (static - coulomb) * exp(-(v / stribeck_velocity) ** 2)"


def _terms(values: Mapping[str, Any]) -> Terms:
    return Terms(f"-({sliding(values)}) * tanh(v / rest_velocity) - viscous * v")


FRICTION = CoordinateForce(
    kind="friction",
    meaning="friction of Coulomb and Stribeck",
    remark="-(coulomb + (static - coulomb) exp(-(v/stribeck_velocity)^2)) tanh(v/rest_velocity) "
    "- viscous v. At rest it creeps: below `rest_velocity` it is a damper. `bristle_friction` "
    "sticks.",
    keys=(
        COULOMB,
        STATIC,
        STRIBECK,
        VISCOUS,
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
)
