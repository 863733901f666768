"""Checks of the expressions of a case: names, functions, coordinates."""

from ...errors import InputError
from ...math.expressions import operations as op
from .check_places import check_place
from .expressions import CaseScope, PlaceCheck, expression
from .force_terms import force_terms
from .forces import CoordinateTable, ForceTable
from .laws import RotationDrive, TranslationDrive
from .of_time import law
from .schema import Mechanism


def check_force(key: str, force: ForceTable, mechanism: Mechanism) -> list[str]:
    """Return errors of the expressions of a force."""
    name = key.partition(".")[2]
    try:
        if isinstance(force, CoordinateTable):
            force_terms(name, force, mechanism, _places(mechanism))
            return []
        of_time = law(force)
        if of_time is not None and of_time.expression is not None:
            scope = CaseScope(mechanism, check=_places(mechanism))
            expression(of_time.expression, scope, f"{key}.expression")
    except InputError as error:
        return [str(error)]
    return []


def _places(mechanism: Mechanism) -> PlaceCheck:
    return lambda place: check_place("reads", place, mechanism, ground=True)


def check_drive(
    key: str, drive: RotationDrive | TranslationDrive, mechanism: Mechanism
) -> list[str]:
    """Return errors of the expression of a drive, which depends on the time alone."""
    if drive.expression is None:
        return []
    try:
        tree = expression(drive.expression, CaseScope(mechanism), f"{key}.expression")
    except InputError as error:
        return [str(error)]
    if any(leaf.code != op.TIME for leaf in tree.leaves()):
        return [
            f'{key}.expression = "{drive.expression}": expected the time t and parameters alone; '
            "a drive that follows the motion is a controller or coordinate_force"
        ]
    return []
