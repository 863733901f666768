"""Checks of the expressions of a case: names, functions, coordinates."""

from ...errors import InputError
from ...math.curves import NamedCurve
from ...math.expressions import operations as op
from ...math.expressions.parse import MADE, NAMES
from .check_places import check_place
from .expressions import WORDS, CaseScope, PlaceCheck, expression, of_time_alone
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


def check_tables(mechanism: Mechanism) -> list[str]:
    """Return tables whose names mean something else in expressions."""
    others = {
        "a function of expressions": {*op.FUNCTIONS, *MADE, *WORDS},
        "a name of expressions": {*NAMES, "x", "v"},
        "one of [parameters] too": mechanism.parameters,
    }
    return [
        f"tables.{name}: is {what}; expected another name"
        for name in mechanism.tables
        for what, words in others.items()
        if name in words
    ]


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
    if not of_time_alone(tree):
        return [
            f'{key}.expression = "{drive.expression}": expected the time t and parameters alone; '
            "a drive that follows the motion is a controller or coordinate_force"
        ]
    for leaf in tree.leaves():
        curve = leaf.quantity
        if isinstance(curve, NamedCurve) and mechanism.tables[curve.name].interpolation == "linear":
            return [
                f"{key}.expression: calls tables.{curve.name}, whose rate jumps; expected "
                'interpolation = "cubic" or "pchip" in a drive'
            ]
    return []
