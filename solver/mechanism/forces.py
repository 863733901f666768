"""Force elements and loads from the tables of a case."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.forces.contract import Number, Three
from ..dynamics.forces.table import ELEMENTS
from ..dynamics.tables import ForceTable
from ..errors import InputError
from ..inputs.case.expressions import CaseScope, expression, of_time_alone
from ..inputs.case.of_time import is_along, is_load, law
from ..math import laws
from .laws import law_of
from .measured import Reader
from .places import Places, axes

if TYPE_CHECKING:
    from ..inputs.case.forces import ElementTable, LoadTable
    from ..inputs.case.schema import Mechanism

_Z = [0.0, 0.0, 1.0]


def force_tables(mechanism: "Mechanism", places: Places, reader: Reader) -> list[ForceTable]:
    """Return the force elements in the order of the case; `reader` gets what they read."""
    found = []
    for name, force in mechanism.forces.items():
        if is_along(force):
            found.append(reader.force(name, force))
            continue
        given = law(force)
        table = _load(name, force, places) if is_load(force) else _element(name, force, places)
        if given is not None and given.expression is not None:
            tree = expression(given.expression, CaseScope(mechanism), f"forces.{name}.expression")
            if of_time_alone(tree):  # a law: an input of linearised equations and of FMUs
                table = replace(table, law=laws.of_expression(tree))
            else:
                table = replace(table, size=reader.placed(tree))
        elif given is not None:
            table = replace(table, law=law_of(given))
        found.append(table)
    return found


def _element(name: str, force: "ElementTable", places: Places) -> ForceTable:
    kind = ELEMENTS[force.kind]
    A_GM = axes(getattr(force, "axis", _Z), getattr(force, "axis_1", None))
    key = f"forces.{name}.between"
    one, two = (places.marker(key, place, A_GM) for place in force.between)
    given = {k.name: getattr(force, k.name) for k in kind.keys if isinstance(k, Number | Three)}
    given["between"] = force.between
    try:
        numbers = kind.numbers(given, places.shift(one, two))
    except InputError as error:
        raise InputError(f"forces.{name}{error}") from error
    return ForceTable(name, force.kind, one, two, numbers)


def _load(name: str, load: "LoadTable", places: Places) -> ForceTable:
    at = places.marker(f"forces.{name}.at", load.at, np.eye(3))
    reference = at if load.frame == "following" else places.ground_axes()
    direction = np.array(load.direction, dtype=float)
    direction /= np.linalg.norm(direction)
    return ForceTable(name, load.kind, reference, at, tuple(direction.tolist()))
