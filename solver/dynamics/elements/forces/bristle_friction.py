"""Friction with an elastic bristle that sticks and slides: the LuGre model.

C. Canudas de Wit, H. Olsson, K. J. Astrom and P. Lischinsky, A new model for control of systems
with friction, IEEE Trans. Automatic Control 40 (1995) 419-425:

    zdot = v - s0 |v| z / g(v),   F = s0 z + s1 zdot + s2 v,
    g(v) = Fc + (Fs - Fc) exp(-(v / vs)^2).

By the load of a contact, F is the same with coefficients in place of Fc and Fs, times the load.
"""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from .bearing import COEFFICIENT, by_reaction, contact
from .contract import CoordinateForce, Number, State, Terms
from .friction import SLIDING, sliding


def _terms(values: Mapping[str, Any]) -> Terms:
    rate = "v - bristle_stiffness * abs(v) * bristle / sliding"
    held = f"bristle_stiffness * bristle + bristle_damping * ({rate})"
    largest, load = max(values["coulomb"], values["static"] or 0.0), "1"
    if by_reaction(values):
        if largest:
            raise InputError(".coulomb: expected without coefficient")
        load = contact(values)
        largest = max(values[COEFFICIENT], values["static_coefficient"] or 0.0)
    if not largest:
        raise InputError(": has no effect; expected coulomb or coefficient above 0")
    return Terms(
        force=f"-(({load}) * ({held}) + viscous * v)",
        names={"sliding": sliding(values, "1")},
        states=(State("bristle", rate, scale=largest / values["bristle_stiffness"]),),
    )


BRISTLE_FRICTION = CoordinateForce(
    kind="bristle_friction",
    meaning="friction that sticks and slides, the LuGre model",
    remark="The deflection of the bristle is an auxiliary state, 0 at the start. With "
    "`coefficient`, stiffness and damping of the bristle are over the load of the contact, so that "
    "the deflection at which it slides does not depend on the load.",
    keys=(
        *SLIDING,
        Number(
            "bristle_stiffness",
            "N/m or N m/rad; by coefficient: 1/m or 1/rad",
            "of the contact before it slides",
            required=True,
            above=0.0,
        ),
        Number(
            "bristle_damping",
            "N s/m or N m s/rad; by coefficient: s/m or s/rad",
            "of the contact before it slides",
            default=0.0,
            least=0.0,
        ),
    ),
    terms=_terms,
    order=8,
)
