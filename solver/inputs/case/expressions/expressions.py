"""What the expressions of a case may read: parameters, joints, places and signals by name."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ....dynamics.elements.couplings.table import COUPLINGS
from ....dynamics.elements.joints.table import JOINTS
from ....errors import InputError, nearest, unknown
from ....math.curves import NamedCurve, curve_of_table
from ....math.expressions import operations as op
from ....math.expressions.parse import ExpressionError, parsed
from ....math.expressions.tree import Node, NoRate, constant
from ....math.rows import column

if TYPE_CHECKING:
    from ..tables.kinds import CouplingTable
    from ..tables.laws import TablePoints
    from ..tables.schema import Mechanism

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
)
OF_MOTION = ("joint", "place", "spin", "length")  # kinds of `Read` with a rate
REACTIONS = ("radial", "axial", "bending", "twisting")  # as in dynamics/model/model.py


@dataclass(frozen=True)
class Read:
    """A quantity by the names of the case.

    Attributes
    ----------
    kind : joint (name, coordinate), place (name, axis), spin (name, axis), length (place, place),
        state (force, name), reaction (joint, one of REACTIONS)
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
            return load(replace(quantity, rate=True))
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
    return load(replace(node.quantity, rate=True))


def joint_coordinate(mechanism: "Mechanism", name: str, coordinate: str | None) -> tuple[str, str]:
    """Return joint and coordinate by name.

    Raises ValueError : no such joint or coordinate, or several to choose from.
    """
    if name not in mechanism.joints:
        raise ValueError(f"there is no joint {name}{nearest(name, mechanism.joints)}")
    free = [c.name for c in JOINTS[mechanism.joints[name].kind].coordinates]
    if coordinate is None and len(free) == 1:
        return name, free[0]
    if coordinate is None or coordinate not in free:
        found = "" if coordinate is None else f', not "{coordinate}"'
        expected = f"expected one of {', '.join(free)}" if free else "it has no coordinate"
        raise ValueError(f"joint {name} is {mechanism.joints[name].kind}{found}; {expected}")
    return name, coordinate


def expression(text: str, scope: CaseScope, key: str) -> Node:
    """Return the tree of an expression.

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
