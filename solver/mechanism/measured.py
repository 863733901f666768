"""Coordinates of markers, states and curves that the expressions of a case read."""

from collections.abc import Hashable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.joints.contract import Displacement
from ..dynamics.joints.table import COORDINATES
from ..dynamics.measured import (
    CoordinateTable,
    Measured,
    StateTable,
    curve,
    rate_of,
    reaction,
    state,
    value,
)
from ..dynamics.quantities import ANGLE, DISPLACEMENT, DISTANCE, SPIN
from ..dynamics.tables import ForceTable, JointTable
from ..inputs.case.expressions import AXES, REACTIONS, Read
from ..inputs.case.force_terms import force_terms
from ..math.curves import NamedCurve
from ..math.curves import curve as curve_of
from ..math.expressions.program import value_at
from ..math.expressions.tree import Node
from ..math.laws import law_value
from .joints import BuiltJoint
from .places import Places

if TYPE_CHECKING:
    from ..inputs.case.forces import CoordinateTable as CoordinateKeys
    from ..inputs.case.schema import Mechanism


class Reader:
    """Turns the names that expressions read into coordinates, states and curves of a model.

    Attributes
    ----------
    found : what has been read so far
    """

    def __init__(
        self,
        mechanism: "Mechanism",
        places: Places,
        joints: dict[str, BuiltJoint],
        tables: list[JointTable],
    ) -> None:
        self.mechanism, self.places = mechanism, places
        self.found = Measured()
        self._joints, self._tables = joints, tables
        self._states: dict[tuple[str, ...], int] = {}
        self._curves: dict[tuple[str, str], int] = {}
        self._places: dict[str, int] = {}

    def force(self, name: str, keys: "CoordinateKeys") -> ForceTable:
        """Return a force along a coordinate, with its states and curves."""
        terms = force_terms(name, keys, self.mechanism)
        for curve_name in terms.curves:
            given = getattr(keys, curve_name)
            law = curve_of(given.x, given.y, smooth=given.interpolation == "spline")
            self._curves[name, curve_name] = self.found.curve(law)
        along = self._coordinate(terms.along)
        # Their expressions may read each other: numbers first.
        first = len(self.found.states)
        for j, own in enumerate(terms.states):
            self._states[name, own.name] = first + j
        for own in terms.states:
            rate = None if own.rate is None else self.placed(own.rate)
            start = self.placed(own.start)
            update = None if own.update is None else self.placed(own.update)
            jumps = own.level is None and (own.update is not None or own.inputs is not None)
            period = float(keys.sample_time) if jumps else 0.0  # type: ignore[attr-defined]
            inputs = None if own.inputs is None else [self.placed(node) for node in own.inputs]
            label = f"{name}.{own.name}"
            event = None
            if own.level is not None:
                event = along, own.level, 1.0 if own.upwards else -1.0
            kept = StateTable(label, rate, start, own.scale, update, period, inputs, name, event)
            self.found.state(kept)
        table = self.found.coordinates[along]
        size = self.placed(terms.force)
        return ForceTable(name, keys.kind, table.marker_1, table.marker_2, size=size, along=along)

    def placed(self, node: Node) -> Node:
        """Return a tree with the quantities of the model for those of the case."""
        quantity = None if node.quantity is None else self._quantity(node.quantity)
        children = tuple(self.placed(child) for child in node.children)
        return replace(node, children=children, quantity=quantity)

    def _quantity(self, read: Hashable) -> Hashable:
        if isinstance(read, NamedCurve):
            return read
        if not isinstance(read, Read):
            assert isinstance(read, tuple)
            return curve(self._curves[read])
        if read.kind == "state":
            return state(self._states[read.names])
        if read.kind == "reaction":
            joint = self._joints[read.names[0]].rows[0]  # without the drives
            return reaction(self.found.reaction(joint, REACTIONS.index(read.names[1])))
        m = self._coordinate(read)
        return rate_of(m) if read.rate else value(m)

    def of_joint(self, name: str, coordinate: str) -> int:
        """Return the number of a coordinate of a joint."""
        return self.found.coordinate(self._of_joint(name, coordinate))

    def _coordinate(self, read: Read) -> int:
        names = read.names
        if read.kind == "joint":
            return self.of_joint(*names)
        one, two = (self._place(place) for place in self._pair(read))
        if read.kind == "length":
            return self.found.coordinate(CoordinateTable(DISTANCE, one, two))
        kind = SPIN if read.kind == "spin" else DISPLACEMENT
        axis = AXES.index(names[1])
        return self.found.coordinate(CoordinateTable(kind, one, two, (axis,)))

    def _pair(self, read: Read) -> tuple[str, str]:
        return (read.names[0], read.names[1]) if read.kind == "length" else ("", read.names[0])

    def _place(self, place: str) -> int:
        """Return the marker of a place, with global axes at the start; of the ground for ""."""
        if place not in self._places:
            self._places[place] = (
                self.places.marker("expression", place, np.eye(3))
                if place
                else self.places.ground_axes()
            )
        return self._places[place]

    def _of_joint(self, name: str, coordinate: str) -> CoordinateTable:
        built, of = self._joints[name], COORDINATES[coordinate]
        table = self._tables[built.rows[0]]
        one, two = table.marker_1, table.marker_2
        if isinstance(of, Displacement):
            return CoordinateTable(DISPLACEMENT, one, two, (of.axis,), float(built.shift[of.axis]))
        axes = (of.frame - 1, of.x, of.y, of.arm)
        return CoordinateTable(ANGLE, one, two, axes, first=self._first(built))

    def _first(self, built: BuiltJoint) -> float:
        """Return the angle at which a driven joint starts [rad]."""
        for row in built.rows[1:]:
            law = self._tables[row].law
            if self._tables[row].kind == "rotation_drive" and law is not None:
                if law.expression is not None:
                    return value_at(law.expression)
                start = np.array([0, len(law.times)], dtype=np.int64)
                return float(law_value(start, law.times, law.coefficients, 0, 0.0)[0])
        return 0.0
