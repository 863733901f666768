"""Force elements (springs, bushings, loads) from the tables of a case."""

from typing import Any

import numpy as np

from ..dynamics.tables import ForceTable
from .laws import law_of
from .places import Places, axes


def force_tables(mechanism: dict[str, Any], places: Places) -> list[ForceTable]:
    """Return the force elements in the order of the case."""
    return [_element(name, t, places) for name, t in mechanism["forces"].items()]


def _element(name: str, table: dict[str, Any], places: Places) -> ForceTable:
    kind = table["kind"]
    if kind in ("force", "torque"):
        return _load(name, table, places)
    A_GM = axes(table.get("axis") or [0.0, 0.0, 1.0], table.get("axis_1"))
    key = f"forces.{name}.between"
    one, two = (places.marker(key, place, A_GM) for place in table["between"])
    if kind == "bushing":
        words = ("stiffness", "rotary_stiffness", "damping", "rotary_damping")
        return ForceTable(name, kind, one, two, tuple(x for word in words for x in table[word]))
    law = law_of(table["actuator"]) if table["actuator"] is not None else None
    rest = table["angle"] if kind == "rotary_spring" else table["length"]
    if rest is None:
        rest = float(np.linalg.norm(places.shift(one, two)))
    return ForceTable(name, kind, one, two, (table["stiffness"], table["damping"], rest), law)


def _load(name: str, table: dict[str, Any], places: Places) -> ForceTable:
    at = places.marker(f"forces.{name}.at", table["at"], np.eye(3))
    reference = at if table["frame"] == "following" else places.ground_axes()
    direction = np.array(table["direction"], dtype=float)
    direction /= np.linalg.norm(direction)
    law = law_of(table["law"])
    return ForceTable(name, table["kind"], reference, at, tuple(direction.tolist()), law)
