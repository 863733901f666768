"""Load of the contact in a joint, by the reaction of the joint: what friction is proportional to.

A pin in a bore of the radius r, or a slider on its guide, carries the force R across the axis of
the joint. A moment M across the axis is a pair of forces at the ends of the guide, 2 M / length
each. On a collar the force along the axis acts at its radius; a key or a flat guide takes a moment
about the axis of a slider at the arm `radius`. The contacts are added.
"""

from collections.abc import Mapping
from typing import Any

from ....errors import InputError
from .contract import BOTH, ROTATION, Number

COEFFICIENT = "coefficient"
_ARMS = ("radius", "collar_radius", "length")
_FURTHER = ("static_coefficient", *_ARMS)
JAMMING = (COEFFICIENT, *_FURTHER)  # keys that decide whether a joint jams
BY_REACTION = (
    Number(
        COEFFICIENT,
        "",
        "of friction by the reaction of the joint, at fast sliding; absent: none",
        least=0.0,
    ),
    Number(
        "static_coefficient",
        "",
        "the same at the onset of sliding; absent: `coefficient`",
        least=0.0,
    ),
    Number(
        "radius",
        "m",
        "of the pin of a hinge; of a slider the arm at which it is held against rotation, "
        "absent: no friction by the moment about its axis; in a cylindrical joint that of the "
        "shaft: friction is then against its velocity along and around the axis together",
        above=0.0,
    ),
    Number(
        "collar_radius",
        "m",
        "of the collar that takes the force along the axis of a hinge; absent: no friction there",
        above=0.0,
    ),
    Number(
        "length",
        "m",
        "of the bearing or guide, which takes moments across the axis at its ends; absent: no "
        "friction by them",
        above=0.0,
    ),
)


def slip(values: Mapping[str, Any]) -> str:
    """Return the speed at which the contact slides as an expression, in the unit of the rate v.

    A shaft that turns and moves along its axis has one contact: friction is against its whole
    velocity. Its share along the coordinate is v over this speed, which is never zero.
    """
    if values[COEFFICIENT] is None or values["radius"] is None or not values[BOTH]:
        return ""
    other = "other / radius" if values[ROTATION] else "radius * other"
    return f"sqrt(v ** 2 + ({other}) ** 2 + (1e-6 * rest_velocity) ** 2)"


def by_reaction(values: Mapping[str, Any]) -> bool:
    """Return whether friction depends on the reaction.

    Raises
    ------
    InputError
        Keys that have a meaning with `coefficient` only.
    """
    if values[COEFFICIENT] is not None:
        return True
    for key in _FURTHER:
        if values[key] is not None:
            raise InputError(f".{key} = {values[key]:g}: expected with coefficient only")
    return False


def contact(values: Mapping[str, Any]) -> str:
    """Return the load of the contact [N], times its arm at a hinge [N m], as an expression."""
    rotation = values[ROTATION]
    if rotation is None:
        raise InputError(
            f".{COEFFICIENT}: expected with the angle or z of a revolute, prismatic, cylindrical "
            "or point_on_line joint"
        )
    across = "radial" if values["length"] is None else "(radial + 2 * bending / length)"
    if not rotation:
        if values["collar_radius"] is not None:
            raise InputError(".collar_radius: expected with the angle of a joint only")
        free = values["radius"] is None or values[BOTH]  # no moment about the axis
        return across if free else f"{across} + twisting / radius"
    if values["radius"] is None and values["collar_radius"] is None:
        raise InputError(".radius: missing; expected the radius of the pin, or collar_radius")
    if values["radius"] is None and values["length"] is not None:
        raise InputError(".length: expected with radius")
    parts = [] if values["radius"] is None else [f"radius * {across}"]
    if values["collar_radius"] is not None:
        parts.append("collar_radius * axial")
    return " + ".join(parts)
