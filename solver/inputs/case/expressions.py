"""Expressions of a case: what they may read, laws of time, forces along a coordinate."""

import math
from collections.abc import Callable, Hashable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from ...dynamics.elements.couplings.table import COUPLINGS
from ...dynamics.elements.forces.contract import BOTH, ROTATION, Contact, Terms
from ...dynamics.elements.forces.table import COORDINATE_FORCES, ELEMENTS, LOADS
from ...dynamics.elements.joints.contract import ANGLE, Z
from ...dynamics.elements.joints.table import JOINTS
from ...errors import InputError, collected, nearest, unknown
from ...math.catalogue import Curve, Expression, Expressions, Number
from ...math.expressions import operations as op
from ...math.expressions.parse import ExpressionError, parsed
from ...math.expressions.program import Node, NoRate, constant
from ...math.laws import NamedCurve, curve_of_table
from ...math.rows import column

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from .tables.kinds import (
        ContactTable,
        CoordinateTable,
        CouplingTable,
        ForceTable,
        JointTable,
        LoadTable,
    )
    from .tables.laws import LoadLaw, RotationDrive, TablePoints, TranslationDrive
    from .tables.schema import Mechanism


_WORDS = {"rad": "a rotation", "m": "a displacement"}


def coupled(
    name: str, coupling: "CouplingTable", mechanism: "Mechanism"
) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return joint and coordinate of both sides.

    Parameters
    ----------
    name : name of the coupling
    coupling : its table
    mechanism : tables of the case, checked for types and bounds

    Raises
    ------
    InputError
        No such joint or coordinate, or not the only one; both are the same.
    """
    pairs = []
    for side, joint in enumerate(coupling.joints):
        key, unit = f"couplings.{name}", COUPLINGS[coupling.kind].units[side]
        if wrong := unknown(f"{key}.joints", joint, "joint", mechanism.joints):
            raise InputError(wrong[0])
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
        pairs.append((joint, given or free[0]))
    if pairs[0] == pairs[1]:
        raise InputError(f"couplings.{name}: expected two different coordinates")
    return pairs[0], pairs[1]


def check_couplings(mechanism: "Mechanism") -> list[str]:
    """Return errors of the couplings of a case."""
    problems: list[str] = []
    for name, coupling in mechanism.couplings.items():
        with collected(problems):
            coupled(name, coupling, mechanism)
    return problems


PlaceCheck = Callable[[str], list[str]]  # errors of a place by its name

AXES = ("x", "y", "z")
# Functions that read the motion: methods of `CaseScope`.
WORDS = (
    "joint",
    "joint_rate",
    "position",
    "velocity",
    "angular_velocity",
    "distance",
    "distance_rate",
    "signal",
    "state",
)
CONTACT_KEYS = ("axis", "radius", "other_radius", "disc_axis")
OF_MOTION = ("joint", "place", "spin", "length", "height", "slip")  # kinds of `Read` with a rate
REACTIONS = ("radial", "axial", "bending", "twisting")  # as in dynamics/model/model.py


class Read(NamedTuple):
    """A quantity by the names of the case.

    Attributes
    ----------
    kind : joint (name, coordinate), place (name, axis), spin (name, axis), length (place, place),
        state (force, name; of `[states]` with "" for the force), reaction (joint, one of REACTIONS)
    names : as above
    rate : the rate by time of it, not itself
    """

    kind: str
    names: tuple[str, ...]
    rate: bool = False

    def __str__(self) -> str:
        return f"{self.kind} {'.'.join(self.names)}"


def load(read: Read) -> Node:
    """Return the node that reads a quantity."""
    return Node(op.LOAD, quantity=read)


class CaseScope:
    """Names and functions of expressions in a case.

    Parameters
    ----------
    mechanism : the case
    names : more names
    own : more functions, of one number
    check : of places; None: they are known
    """

    def __init__(
        self,
        mechanism: "Mechanism",
        names: Mapping[str, Node] | None = None,
        own: Mapping[str, Callable[..., Node]] | None = None,
        check: PlaceCheck | None = None,
    ) -> None:
        self.mechanism, self._check = mechanism, check
        given = {name: constant(value) for name, value in mechanism.parameters.items()}
        self.names: dict[str, Node] = {**given, **(names or {})}
        self.functions: dict[str, Callable[..., Node]] = {
            **{name: _called(name, table) for name, table in mechanism.tables.items()},
            **{word: getattr(self, word) for word in WORDS},
            **(own or {}),
        }

    def rate(self, quantity: Hashable) -> Node:
        """Return the rate of a quantity."""
        if isinstance(quantity, Read) and not quantity.rate and quantity.kind in OF_MOTION:
            return load(quantity._replace(rate=True))
        raise NoRate("has a rate by time that is not known: it reads a rate or a state")

    def joint(self, name: str, coordinate: str | None = None) -> Node:
        """Return the coordinate of a joint; without its name, the only one."""
        return load(Read("joint", joint_coordinate(self.mechanism, name, coordinate)))

    def joint_rate(self, name: str, coordinate: str | None = None) -> Node:
        """Return the rate of a coordinate of a joint."""
        return _rate_of(self.joint(name, coordinate))

    def position(self, place: str, axis: str) -> Node:
        """Return a global coordinate of a place."""
        return load(Read("place", self._place(place, axis)))

    def velocity(self, place: str, axis: str) -> Node:
        """Return a global component of the velocity of a place."""
        return load(Read("place", self._place(place, axis), True))

    def angular_velocity(self, place: str, axis: str) -> Node:
        """Return a global component of the angular velocity of a place."""
        return load(Read("spin", self._place(place, axis), True))

    def distance_rate(self, one: str, two: str) -> Node:
        """Return the rate of the distance of two places."""
        return _rate_of(self.distance(one, two))

    def distance(self, one: str, two: str) -> Node:
        """Return the distance of two places."""
        for place in (one, two):
            self._known(place)
        return load(Read("length", (one, two)))

    def signal(self, name: str) -> Node:
        """Return what a signal of the motion measures."""
        signals = self.mechanism.signals
        if name not in signals:
            raise ValueError(f"reads no known signal{nearest(name, signals)}")
        signal = signals[name]
        scale = constant(1.0 / (signal.divide_by or 1.0))
        if signal.kind == "joint":
            return self.joint(signal.joint, signal.coordinate) * scale
        if signal.kind not in ("position", "velocity", "angular_velocity"):
            expected = "expected joint, position, velocity or angular_velocity"
            raise ValueError(f"is a signal of kind {signal.kind}; {expected}")
        if signal.component == "magnitude":
            raise ValueError("is a signal with component magnitude; expected x, y or z")
        return self.functions[signal.kind](signal.at, signal.component) * scale

    def state(self, name: str) -> Node:
        """Return the value of `[states.NAME]`."""
        if name not in self.mechanism.states:
            raise ValueError(f"reads no known state{nearest(name, self.mechanism.states)}")
        return load(Read("state", ("", name)))

    def _place(self, place: str, axis: str) -> tuple[str, str]:
        self._known(place)
        if axis not in AXES:
            raise ValueError('needs an axis; expected "x", "y" or "z"')
        return place, axis

    def _known(self, place: str) -> None:
        for problem in self._check(place) if self._check is not None else ():
            raise ValueError(problem)


def of_time_alone(tree: Node) -> bool:
    """Whether an expression reads nothing but the time, parameters, and curves of them."""
    return all(leaf.code in (op.TIME, op.CURVE) for leaf in tree.leaves())


def _called(name: str, table: "TablePoints") -> Callable[[Node], Node]:
    def call(x: Node) -> Node:
        points = column(table.x), column(table.y)
        kind = table.interpolation, table.extrapolation
        return Node(op.CURVE, (x,), quantity=NamedCurve(name, curve_of_table(*points, *kind)))

    return call


def _rate_of(node: Node) -> Node:
    assert isinstance(node.quantity, Read)
    return load(node.quantity._replace(rate=True))


def joint_coordinate(mechanism: "Mechanism", name: str, coordinate: str | None) -> tuple[str, str]:
    """Return joint and coordinate by name.

    Parameters
    ----------
    mechanism : tables of the case, checked for types and bounds
    name : name of the joint
    coordinate : name of the coordinate; None: the only one

    Raises
    ------
    ValueError : no such joint or coordinate, or several to choose from.
    """
    if name not in mechanism.joints:
        raise ValueError(f"there is no joint {name}{nearest(name, mechanism.joints)}")
    free = [c.name for c in JOINTS[mechanism.joints[name].kind].coordinates]
    if coordinate is None and len(free) == 1:
        return name, free[0]
    if coordinate is None or coordinate not in free:
        hint = "" if coordinate is None else f', not "{coordinate}"'
        expected = f"expected one of {', '.join(free)}" if free else "it has no coordinate"
        raise ValueError(f"joint {name} is {mechanism.joints[name].kind}{hint}; {expected}")
    return name, coordinate


def expression(text: str, scope: CaseScope, key: str) -> Node:
    """Return the tree of an expression.

    Parameters
    ----------
    text : text of the expression
    scope : names that it may use
    key : key of the input file, for messages

    Raises
    ------
    InputError
        It cannot be used; begins with the key.
    """
    try:
        return parsed(text, scope)
    except ExpressionError as error:
        shown = text if len(text) < 60 else text[:57] + "..."
        hint = nearest(error.word, error.known) if error.word else ""
        raise InputError(f'{key} = "{shown}": {error}{hint}') from error


def state_rates(mechanism: "Mechanism", check: PlaceCheck | None = None) -> dict[str, Node]:
    """Return the rates of `[states]`, as trees.

    Raises
    ------
    InputError
    """
    scope = CaseScope(mechanism, check=check)
    return {
        name: expression(equation.rate, scope, f"states.{name}.rate")
        for name, equation in mechanism.states.items()
    }


def drives(joint: "JointTable") -> dict[str, "RotationDrive | TranslationDrive"]:
    """Return the drives of a joint by their keys."""
    laws = {name: getattr(joint, name) for name in JOINTS[joint.kind].drives}
    return {name: drive for name, drive in laws.items() if drive is not None}


def joint_starts(joint: "JointTable") -> dict[str, float]:
    """Return given coordinates of a joint at the start by the keys of drives [rad or m]."""
    values = {}
    for name, key in JOINTS[joint.kind].drives.items():
        if (value := getattr(joint, key.start, None)) is not None:
            values[name] = math.radians(value) if key.start == "start_deg" else value
    return values


def is_load(force: "ForceTable") -> "TypeIs[LoadTable]":
    """Whether a force comes from outside, at one place."""
    return force.kind in LOADS


def is_along(force: "ForceTable") -> "TypeIs[CoordinateTable | ContactTable]":
    """Whether a force acts along a coordinate."""
    return force.kind in COORDINATE_FORCES


def is_contact(force: "ForceTable") -> "TypeIs[ContactTable]":
    """Whether a force is a contact of a sphere."""
    return isinstance(COORDINATE_FORCES.get(force.kind), Contact)


def law(force: "ForceTable") -> "LoadLaw | None":
    """Return the law of a load, or of the actuator of an element if it has one."""
    if is_load(force):
        return force.law
    if is_along(force):
        return None
    laws = [getattr(force, key) for key in ELEMENTS[force.kind].laws]
    return laws[0] if laws else None


def is_smooth(mechanism: "Mechanism") -> bool:
    """Whether nothing in a mechanism may jump: no contact, feedback, expression or linear table."""
    laws: list[LoadLaw | RotationDrive | TranslationDrive | None] = []
    laws += [law(force) for force in mechanism.forces.values()]
    laws += [each for joint in mechanism.joints.values() for each in drives(joint).values()]
    if mechanism.rotor is not None:  # polars have corners
        return False
    return not any(is_along(force) for force in mechanism.forces.values()) and all(
        each is None
        or (each.expression is None and getattr(each.table, "interpolation", "") != "linear")
        for each in laws
    )


class StateTerms(NamedTuple):
    """An auxiliary state of a force, as trees."""

    name: str
    rate: Node | None
    start: Node
    scale: float
    update: Node | None
    inputs: tuple[Node, ...] | None  # of the user's function that gives its values; None: none
    level: float | None  # of the coordinate, at whose passage it takes `update`
    upwards: bool


class ForceTerms(NamedTuple):
    """A force along a coordinate, as trees."""

    along: Read
    force: Node
    states: tuple[StateTerms, ...]
    curves: tuple[str, ...]  # keys of the curves that are given
    friction: tuple[tuple[Read, Node], ...] = ()  # of a contact, by directions of slip


def force_terms(
    name: str,
    force: "CoordinateTable | ContactTable",
    mechanism: "Mechanism",
    check: PlaceCheck | None = None,
) -> ForceTerms:
    """Return the expressions of `[forces.NAME]`.

    Parameters
    ----------
    name : name of the force
    force : its table
    mechanism : tables of the case, checked for types and bounds
    check : check of places that expressions name

    Raises
    ------
    InputError
    """
    kind = COORDINATE_FORCES[force.kind]
    key = f"forces.{name}"
    along = _along(key, force, mechanism)
    values = {k.name: getattr(force, k.name) for k in kind.keys}
    if isinstance(kind, Contact):
        values |= {key: getattr(force, key) for key in CONTACT_KEYS}
    values[ROTATION] = _rotation(along, mechanism)
    other = _other(along, mechanism)
    values[BOTH] = other is not None
    try:
        terms = kind.terms(values)
    except InputError as error:
        raise InputError(f"{key}{error}") from error
    names = {"x": load(along), "v": load(along._replace(rate=True))}
    public = CaseScope(mechanism, names, check=check)
    for k in kind.keys:
        value = values[k.name]
        if value is None:
            continue
        if isinstance(k, Number):
            names[k.name] = constant(value)
        elif isinstance(k, Expression):
            names[k.name] = expression(value, public, f"{key}.{k.name}")
    if values[ROTATION] is not None:
        names |= {of: load(Read("reaction", (along.names[0], of))) for of in REACTIONS}
    if other is not None:
        names["other"] = load(other)
    slips: tuple[Read, ...] = ()
    if terms.friction:
        count = 2 if values["other_radius"] is None else 3
        slips = tuple(Read("slip", (name, str(i)), rate=True) for i in range(count))
        first, *others = (load(each) * load(each) for each in slips)
        names["slip_squared"] = sum(others, first)
    given = tuple(k.name for k in kind.keys if isinstance(k, Curve) and values[k.name] is not None)
    scope = CaseScope(mechanism, names, {k: _reader((name, k)) for k in given})
    inputs = tuple(
        expression(text, public, f"{key}.{k.name}.{i}")
        for k in kind.keys
        if isinstance(k, Expressions)
        for i, text in enumerate(values[k.name])
    )
    return _trees(name, terms, along, scope, given, inputs, slips)


def _trees(
    name: str,
    terms: Terms,
    along: Read,
    scope: CaseScope,
    curves: tuple[str, ...],
    inputs: tuple[Node, ...],
    slips: tuple[Read, ...],
) -> ForceTerms:
    key = f"forces.{name}"
    starts = []
    for state in terms.states:
        starts.append(expression(state.start, scope, key))
        scope.names[state.name] = load(Read("state", (name, state.name)))
    for part, text in terms.names.items():
        scope.names[part] = expression(text, scope, key)
    force = expression(terms.force, scope, key)

    def optional(text: str | None) -> Node | None:
        return None if text is None else expression(text, scope, key)

    states = tuple(
        StateTerms(
            s.name,
            optional(s.rate),
            start,
            s.scale,
            optional(s.update),
            inputs if s.called else None,
            s.level,
            s.upwards,
        )
        for s, start in zip(terms.states, starts, strict=True)
    )
    friction = []
    for slip in slips:
        scope.names["slip"] = load(slip)
        friction.append((slip._replace(rate=False), expression(terms.friction, scope, key)))
    return ForceTerms(along, force, states, curves, tuple(friction))


def _along(key: str, force: "CoordinateTable | ContactTable", mechanism: "Mechanism") -> Read:
    if is_contact(force):
        if force.other_radius is None:
            return Read("height", (key.partition(".")[2],))
        return Read("length", (force.between[0], force.between[1]))
    if force.joint is None:
        assert force.between is not None
        return Read("length", (force.between[0], force.between[1]))
    try:
        return Read("joint", joint_coordinate(mechanism, force.joint, force.coordinate))
    except ValueError as error:
        where = "joint" if force.joint not in mechanism.joints else "coordinate"
        raise InputError(f"{key}.{where}: {error}") from error


def _rotation(along: Read, mechanism: "Mechanism") -> bool | None:
    """Return `ROTATION` of a coordinate."""
    if along.kind != "joint":
        return None
    joint = JOINTS[mechanism.joints[along.names[0]].kind]
    guided = len(joint.removes) == len(joint.units) and {"x", "y"} <= set(joint.removes)
    return along.names[1] == "angle" if guided and set(joint.coordinates) <= {ANGLE, Z} else None


def _other(along: Read, mechanism: "Mechanism") -> Read | None:
    """Return the rate of the other coordinate of a joint that leaves one axis free; else None."""
    if along.kind != "joint":
        return None
    name, coordinate = along.names
    joint = JOINTS[mechanism.joints[name].kind]
    if set(joint.coordinates) != {ANGLE, Z} or len(joint.units) != 4:  # a screw has five rows
        return None
    return Read("joint", (name, "z" if coordinate == "angle" else "angle"), rate=True)


def _reader(curve: tuple[str, str]) -> Callable[..., Node]:
    return lambda node: Node(op.CURVE, (node,), quantity=curve)
