"""Contact of a sphere with a plane or a sphere: Hunt and Crossley, Hertz, Coulomb.

The normal force is that of a stop (limit_stop.py) on the height of the centre over the plane, or on
the distance of the centres. Friction is Coulomb's, regularised near rest: with the normal force N
and the velocity s of the sliding surfaces it is -coefficient N s / (|s|^2 + rest_velocity^2)^(1/2).
"""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from . import limit_stop
from .contract import Contact, Number, Terms


def _terms(values: Mapping[str, Any]) -> Terms:
    for key in ("axis", "disc_axis"):
        if values[key] is not None and values["other_radius"] is not None:
            raise InputError(f".{key}: expected with a plane only; other_radius makes it a sphere")
    if values["disc_axis"] is not None and not values["radius"] > 0.0:
        raise InputError(".radius = 0: expected the radius of the disc, above 0")
    # The height of a rim is that of its lowest point, of a sphere that of its centre.
    touching = values["radius"] if values["disc_axis"] is None else 0.0
    touching += values["other_radius"] or 0.0
    stop = limit_stop.LIMIT_STOP.terms({**values, "lower": touching, "upper": None})
    friction = ""
    if values["coefficient"]:
        friction = "-coefficient * normal * slip / sqrt(slip_squared + rest_velocity ** 2)"
    names = {"lower": repr(touching), "normal": stop.force}
    return Terms("normal", names, stop.states, friction)


CONTACT = Contact(
    kind="contact",
    meaning="a contact of a sphere, a point or the rim of a disc with a plane, or of two spheres",
    remark="The law of `limit_stop` at the depth d, with the instants of impacts located as there. "
    "Hertz: exponent = 1.5 and stiffness = 4/3 E* R^(1/2), with 1/R = 1/radius + 1/other_radius "
    "and 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2. Friction acts where the surfaces touch, "
    "against their sliding; below `rest_velocity` a body at rest creeps.",
    keys=(
        *(key for key in limit_stop.LIMIT_STOP.keys if key.name not in ("lower", "upper")),
        Number("coefficient", "", "of Coulomb's friction", default=0.0, least=0.0),
        Number(
            "rest_velocity",
            "m/s",
            "sliding at which friction has 1 / sqrt(2) of its size",
            default=1e-3,
            above=0.0,
        ),
    ),
    terms=_terms,
    order=7,
)
