"""Joints, couplings, force elements, laws and measured quantities from the tables of a case."""

from collections.abc import Hashable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.elements.couplings.contract import ROWS
from ..dynamics.elements.couplings.table import COUPLINGS
from ..dynamics.elements.forces.table import ELEMENTS
from ..dynamics.elements.joints.contract import Displacement
from ..dynamics.elements.joints.table import COORDINATES, JOINTS
from ..dynamics.model.model import (
    ANGLE,
    DISPLACEMENT,
    DISTANCE,
    HEIGHT,
    PLANE,
    RIM,
    SLIP,
    SPHERES,
    SPIN,
)
from ..errors import InputError
from ..inputs.case.expressions import (
    AXES,
    REACTIONS,
    CaseScope,
    Read,
    coupled,
    drives,
    expression,
    force_terms,
    is_along,
    is_load,
    joint_starts,
    law,
    of_time_alone,
    state_rates,
)
from ..math import laws
from ..math.arrays import Array
from ..math.catalogue import Number, Three
from ..math.expressions.program import Node, constant, value_at
from ..math.laws import Law, NamedCurve, law_value
from ..math.rows import column
from .built_mechanism import BuiltJoint
from .places import Places, axes
from .tables import (
    CoordinateTable,
    CouplingRow,
    ForceTable,
    JointTable,
    Measured,
    StateTable,
)

if TYPE_CHECKING:
    from ..inputs.case.tables.kinds import CaseJoint, ContactTable, ElementTable, LoadTable
    from ..inputs.case.tables.kinds import CoordinateTable as CoordinateKeys
    from ..inputs.case.tables.laws import LoadLaw, RotationDrive, TranslationDrive, WindLaw
    from ..inputs.case.tables.rotor import Wind
    from ..inputs.case.tables.schema import Mechanism


def drive_law(given: "RotationDrive | TranslationDrive", mechanism: "Mechanism", key: str) -> Law:
    """Return the law of a drive, which may be an expression of the time.

    Parameters
    ----------
    given : table of the drive
    mechanism : tables of the case, checked
    key : key of the case file, for messages
    """
    if given.expression is not None:
        scope = CaseScope(mechanism)
        return laws.of_expression(expression(given.expression, scope, f"{key}.expression"))
    return law_of(given)


def law_of(given: "RotationDrive | TranslationDrive | LoadLaw | WindLaw") -> Law:
    """Return the law of a table that has exactly one and no expression (tables/laws.py)."""
    if given.polynomial is not None:
        return laws.polynomial(given.polynomial)
    if given.smooth_step is not None:
        step = given.smooth_step
        return laws.smooth_step(step.value, step.duration, step.start)
    if given.table is not None:
        points = column(given.table.times), column(given.table.values)
        return laws.table(*points, given.table.interpolation)
    # Keys that only some of the tables have.
    keys = {key: getattr(given, key, None) for key in ("constant", "ramp", "speed")}
    offset = getattr(given, "angle", 0.0) or getattr(given, "displacement", 0.0)
    if keys["constant"] is not None:
        return laws.polynomial([keys["constant"]])
    if keys["ramp"] is not None:
        rise = keys["ramp"]
        return laws.ramp(rise.speed, rise.duration, offset, sine=rise.shape == "sine")
    return laws.polynomial([offset, keys["speed"] or 0.0])


def wind_laws(mechanism: "Mechanism", wind: "Wind") -> tuple[Law, Law]:
    """Return the laws of the wind's speed [m/s] and of the turn of its direction [rad]."""
    turn = np.radians(wind.direction_deg)
    if wind.speed is None:
        times = np.array(wind.times)
        turns = turn + np.radians(np.array(wind.directions_deg))
        speeds = laws.table(times, np.array(wind.speeds), "linear")
        return speeds, laws.table(times, turns, "linear")
    if wind.speed.expression is None:
        return law_of(wind.speed), laws.polynomial([turn])
    tree = expression(wind.speed.expression, CaseScope(mechanism), "rotor.wind.speed.expression")
    return laws.of_expression(tree), laws.polynomial([turn])


def shifted(law: Law, by: float) -> Law:
    """Return a law plus a constant."""
    if law.expression is not None:
        return law._replace(expression=law.expression + constant(by))
    coefficients = law.coefficients.copy()
    coefficients[:, 0] += by
    return law._replace(coefficients=coefficients)


def joint_tables(
    mechanism: "Mechanism", places: Places, share: float = 0.0
) -> tuple[list[JointTable], dict[str, BuiltJoint]]:
    """Return the joints and drives, each drive after its joint, and their positions in the
    model.

    With a `share`, joints are held at this share of their coordinates at the start.

    Parameters
    ----------
    mechanism : tables of the case, checked
    places : places of the mechanism, with their markers
    share : joints are held at this share of their coordinates at the start; 0: not held
    """
    tables: list[JointTable] = []
    built = {}
    for name, joint in mechanism.joints.items():
        kind = joint.kind
        A_GM = axes(getattr(joint, "axis", None) or [0.0, 0.0, 1.0], getattr(joint, "axis_2", None))
        key = f"joints.{name}.between"
        one, two = (places.marker(key, place, A_GM) for place in joint.between)
        shift = places.shift(one, two)
        first = len(tables)
        tables.append(JointTable(name, kind, one, two, parameters=_numbers(name, joint, shift)))
        given = [
            (key, key.replace("_", " "), drive_law(drive, mechanism, f"joints.{name}.{key}"))
            for key, drive in drives(joint).items()
        ]
        if share:
            held = joint_starts(joint).items()
            given += [(key, "start", laws.polynomial([share * at])) for key, at in held]
        for key, text, of_key in given:
            driven = JOINTS[kind].drives[key].drive
            of = driven.coordinate
            start = float(shift[of.axis]) if isinstance(of, Displacement) else 0.0
            label = f"{name} ({text})"
            tables.append(JointTable(label, driven.kind, one, two, shifted(of_key, start)))
        built[name] = BuiltJoint(kind, tuple(range(first, len(tables))), shift)
    return tables, built


def _numbers(name: str, joint: "CaseJoint", shift: Array) -> tuple[float, ...]:
    """Return the numbers of a joint in the order of its kernel."""
    kind = JOINTS[joint.kind]
    given = {key.name: getattr(joint, key.name) for key in kind.keys if isinstance(key, Number)}
    given["between"] = joint.between
    try:
        complete = kind.complete(given, shift)
    except InputError as error:
        raise InputError(f"joints.{name}{error}") from error
    return tuple(complete[key] for key in kind.parameters)


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
        self._contacts: dict[str, tuple[int, int]] = {}

    def states(self) -> None:
        """Add `[states]`, which forces and each other read."""
        rates = state_rates(self.mechanism)
        self._states |= {("", name): j for j, name in enumerate(rates)}
        for name, rate in rates.items():
            keys = self.mechanism.states[name]
            start = constant(keys.start)
            self.found.state(StateTable(name, self.placed(rate), start, keys.size, owner=name))

    def force(self, name: str, keys: "CoordinateKeys | ContactTable") -> list[ForceTable]:
        """Return a force along a coordinate, with its states and curves; then its friction."""
        terms = force_terms(name, keys, self.mechanism)
        for curve_name in terms.curves:
            given = getattr(keys, curve_name)
            law = laws.curve(given.x, given.y, smooth=given.interpolation == "spline")
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
            period = float(keys.sample_time) if jumps else 0.0  # type: ignore[union-attr]
            inputs = None if own.inputs is None else [self.placed(node) for node in own.inputs]
            label = f"{name}.{own.name}"
            event = None
            if own.level is not None:
                event = along, own.level, 1.0 if own.upwards else -1.0
            kept = StateTable(label, rate, start, own.scale, update, period, inputs, name, event)
            self.found.state(kept)
        parts = [(along, name, terms.force)]
        for slip, size in terms.friction:
            parts.append((self._coordinate(slip), f"{name} (friction)", size))
        tables = []
        for m, label, size in parts:
            table, placed = self.found.coordinates[m], self.placed(size)
            markers = table.marker_1, table.marker_2
            tables.append(ForceTable(label, keys.kind, *markers, size=placed, along=m))
        return tables

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
            return "curve", self._curves[read]
        if read.kind == "state":
            return "state", self._states[read.names]
        if read.kind == "reaction":
            joint = self._joints[read.names[0]].rows[0]  # without the drives
            return "reaction", self.found.reaction(joint, REACTIONS.index(read.names[1]))
        return "rate" if read.rate else "value", self._coordinate(read)

    def of_joint(self, name: str, coordinate: str) -> int:
        """Return the number of a coordinate of a joint."""
        return self.found.coordinate(self._of_joint(name, coordinate))

    def _coordinate(self, read: Read) -> int:
        names = read.names
        if read.kind == "joint":
            return self.of_joint(*names)
        if read.kind in ("height", "slip"):
            return self.found.coordinate(self._of_contact(read))
        one, two = (self._place(place) for place in self._pair(read))
        if read.kind == "length":
            return self.found.coordinate(CoordinateTable(DISTANCE, one, two))
        kind = SPIN if read.kind == "spin" else DISPLACEMENT
        axis = AXES.index(names[1])
        return self.found.coordinate(CoordinateTable(kind, one, two, (axis,)))

    def _of_contact(self, read: Read) -> CoordinateTable:
        name = read.names[0]
        keys: ContactTable = self.mechanism.forces[name]  # type: ignore[assignment]
        if name not in self._contacts:
            key, directions = f"forces.{name}.between", (keys.axis, keys.disc_axis)
            one, two = (
                self.places.marker(key, place, axes(z or _Z, None))
                for place, z in zip(keys.between, directions, strict=True)
            )
            self._contacts[name] = one, two
        markers = self._contacts[name]
        shape = PLANE if keys.other_radius is None else SPHERES
        shape = shape if keys.disc_axis is None else RIM
        if read.kind == "slip":
            return CoordinateTable(SLIP, *markers, (int(read.names[1]), shape), keys.radius)
        if shape == RIM:
            return CoordinateTable(HEIGHT, *markers, (2, RIM), keys.radius)
        return CoordinateTable(DISPLACEMENT, *markers, (2,))

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


def coupling_rows(mechanism: "Mechanism", reader: Reader) -> list[CouplingRow]:
    """Return the couplings in the order of the case; `reader` gets their coordinates."""
    rows = []
    for name, coupling in mechanism.couplings.items():
        kind = COUPLINGS[coupling.kind]
        pair = coupled(name, coupling, mechanism)
        values = {key.name: getattr(coupling, key.name) for key in kind.keys}
        terms = [
            (reader.of_joint(*side), ratio)
            for side, ratio in zip(pair, kind.ratios(values), strict=True)
        ]
        rows.append(CouplingRow(name, ROWS[kind.unit], tuple(terms)))
    return rows


_Z = [0.0, 0.0, 1.0]


def force_tables(mechanism: "Mechanism", places: Places, reader: Reader) -> list[ForceTable]:
    """Return the force elements in the order of the case; `reader` gets what they read.

    The friction of contacts is behind all others.

    Parameters
    ----------
    mechanism : tables of the case, checked
    places : places of the mechanism, with their markers
    reader : collects the quantities that the forces read
    """
    tables, friction = [], []
    for name, force in mechanism.forces.items():
        if is_along(force):
            first, *others = reader.force(name, force)
            tables.append(first)
            friction += others
            continue
        given = law(force)
        table = _load(name, force, places) if is_load(force) else _element(name, force, places)
        if given is not None and given.expression is not None:
            tree = expression(given.expression, CaseScope(mechanism), f"forces.{name}.expression")
            if of_time_alone(tree):  # a law: an input of linearised equations and of FMUs
                table = table._replace(law=laws.of_expression(tree))
            else:
                table = table._replace(size=reader.placed(tree))
        elif given is not None:
            table = table._replace(law=law_of(given))
        tables.append(table)
    return tables + friction


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
