"""Places of a body at which a mechanism loads it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .schema import Mechanism


def loaded_places(name: str, mechanism: "Mechanism") -> list[str]:
    """Return the interfaces of a body where joints, force elements or masses act, each once.

    A force along the coordinate of a joint acts at the places of the joint.
    """
    ends = [end for joint in mechanism.joints.values() for end in joint.between]
    ends += [mass.at for mass in mechanism.masses.values()]
    for force in mechanism.forces.values():
        ends += getattr(force, "between", None) or [getattr(force, "at", None) or ""]
    places = [end.partition(".")[2] for end in ends if end.partition(".")[0] == name]
    return list(dict.fromkeys(places))
