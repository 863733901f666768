"""Friction with an elastic bristle that sticks and slides: the LuGre model.

C. Canudas de Wit, H. Olsson, K. J. Astrom and P. Lischinsky, A new model for control of systems
with friction, IEEE Trans. Automatic Control 40 (1995) 419-425:

    zdot = v - s0 |v| z / g(v),   F = s0 z + s1 zdot + s2 v,
    g(v) = Fc + (Fs - Fc) exp(-(v / vs)^2).
"""

from collections.abc import Mapping
from typing import Any

from .contract import CoordinateForce, Number, State, Terms
from .friction import COULOMB, STATIC, STRIBECK, VISCOUS, sliding


def _terms(values: Mapping[str, Any]) -> Terms:
    largest = max(values["coulomb"], values["static"] or 0.0)
    rate = "v - bristle_stiffness * abs(v) * bristle / sliding"
    return Terms(
        force=f"-(bristle_stiffness * bristle + bristle_damping * ({rate}) + viscous * v)",
        names={"sliding": sliding(values)},
        states=(State("bristle", rate, scale=largest / values["bristle_stiffness"]),),
    )


BRISTLE_FRICTION = CoordinateForce(
    kind="bristle_friction",
    meaning="friction that sticks and slides, the LuGre model",
    remark="The deflection of the bristle is an auxiliary state, 0 at the start.",
    keys=(
        Number("coulomb", COULOMB.unit, COULOMB.meaning, required=True, above=0.0),
        STATIC,
        STRIBECK,
        VISCOUS,
        Number(
            "bristle_stiffness",
            "N/m or N m/rad",
            "of the contact before it slides",
            required=True,
            above=0.0,
        ),
        Number(
            "bristle_damping",
            "N s/m or N m s/rad",
            "of the contact before it slides",
            default=0.0,
            least=0.0,
        ),
    ),
    terms=_terms,
    order=8,
)
