"""Check of a place of a case: a body and one of its interfaces, or a point of the ground."""

from ...errors import nearest
from .check_bodies import interfaces
from .schema import Mechanism


def check_place(key: str, place: str, mechanism: Mechanism, *, ground: bool) -> list[str]:
    """Return errors of a place "BODY.INTERFACE" or "ground.POINT"."""
    owner, dot, point = place.partition(".")
    if not dot:
        expected = '"BODY.INTERFACE"' + (' or "ground.POINT"' if ground else "")
        return [f'{key} = "{place}": expected {expected}']
    if owner == "ground" and ground:
        if point in mechanism.ground:
            return []
        hint = nearest(point, mechanism.ground)
        return [f'{key} = "{place}": the ground has no point "{point}"{hint}']
    if owner not in mechanism.bodies:
        return [f'{key} = "{place}": there is no body "{owner}"{nearest(owner, mechanism.bodies)}']
    known = interfaces(mechanism.bodies[owner])
    if known is not None and point not in known:
        return [
            f'{key} = "{place}": body "{owner}" has no interface "{point}"{nearest(point, known)}'
        ]
    return []
