"""Which coordinates the couplings of a case hold together."""

from typing import TYPE_CHECKING

from ...dynamics.elements.couplings.table import COUPLINGS
from ...dynamics.elements.joints.table import JOINTS
from ...errors import InputError, nearest

if TYPE_CHECKING:
    from .couplings import CouplingTable
    from .schema import Mechanism

_WORDS = {"rad": "a rotation", "m": "a displacement"}


def coupled(
    name: str, coupling: "CouplingTable", mechanism: "Mechanism"
) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return joint and coordinate of both sides.

    Raises
    ------
    InputError
        No such joint or coordinate, or not the only one; both are the same.
    """
    found = []
    for side, joint in enumerate(coupling.joints):
        key, unit = f"couplings.{name}", COUPLINGS[coupling.kind].units[side]
        if joint not in mechanism.joints:
            hint = nearest(joint, mechanism.joints)
            raise InputError(f'{key}.joints = "{joint}": no such joint{hint}')
        kind = mechanism.joints[joint].kind
        free = [c.name for c in JOINTS[kind].coordinates if c.unit == unit]
        given = coupling.coordinates[side] if coupling.coordinates is not None else None
        if not free:
            raise InputError(
                f'{key}.joints = "{joint}": {kind}, without {_WORDS[unit]}; '
                f"expected a joint with {_WORDS[unit]}"
            )
        if given is None and len(free) > 1:
            raise InputError(f"{key}.coordinates: missing; joint {joint} has {', '.join(free)}")
        if given is not None and given not in free:
            raise InputError(
                f'{key}.coordinates = "{given}": {_WORDS[unit]} of joint {joint} is expected, '
                f"one of {', '.join(free)}"
            )
        found.append((joint, given or free[0]))
    if found[0] == found[1]:
        raise InputError(f"couplings.{name}: expected two different coordinates")
    return found[0], found[1]


def check_couplings(mechanism: "Mechanism") -> list[str]:
    """Return errors of the couplings of a case."""
    problems = []
    for name, coupling in mechanism.couplings.items():
        try:
            coupled(name, coupling, mechanism)
        except InputError as error:
            problems.append(str(error))
    return problems
