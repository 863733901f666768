"""Forces along a coordinate of a case as trees of expressions."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ....dynamics.elements.forces.contract import BOTH, ROTATION, Terms
from ....dynamics.elements.forces.table import COORDINATE_FORCES
from ....dynamics.elements.joints.contract import ANGLE, Z
from ....dynamics.elements.joints.table import JOINTS
from ....errors import InputError
from ....math.expressions import operations as op
from ....math.expressions.tree import Node, constant
from ....math.keys import Curve, Expression, Expressions, Number
from .expressions import REACTIONS, CaseScope, PlaceCheck, Read, expression, joint_coordinate, load

if TYPE_CHECKING:
    from ..tables.kinds import CoordinateTable
    from ..tables.schema import Mechanism


@dataclass(frozen=True)
class StateTerms:
    """An auxiliary state of a force, as trees."""

    name: str
    rate: Node | None
    start: Node
    scale: float
    update: Node | None
    inputs: tuple[Node, ...] | None  # of the user's function that gives its values; None: none
    level: float | None  # of the coordinate, at whose passage it takes `update`
    upwards: bool


@dataclass(frozen=True)
class ForceTerms:
    """A force along a coordinate, as trees."""

    along: Read
    force: Node
    states: tuple[StateTerms, ...]
    curves: tuple[str, ...]  # keys of the curves that are given


def force_terms(
    name: str, force: "CoordinateTable", mechanism: "Mechanism", check: PlaceCheck | None = None
) -> ForceTerms:
    """Return the expressions of `[forces.NAME]`.

    Raises
    ------
    InputError
    """
    kind = COORDINATE_FORCES[force.kind]
    key = f"forces.{name}"
    along = _along(key, force, mechanism)
    values = {k.name: getattr(force, k.name) for k in kind.keys}
    values[ROTATION] = _rotation(along, mechanism)
    other = _other(along, mechanism)
    values[BOTH] = other is not None
    try:
        terms = kind.terms(values)
    except InputError as error:
        raise InputError(f"{key}{error}") from error
    names = {"x": load(along), "v": load(replace(along, rate=True))}
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
    given = tuple(k.name for k in kind.keys if isinstance(k, Curve) and values[k.name] is not None)
    scope = CaseScope(mechanism, names, {k: _reader((name, k)) for k in given})
    inputs = tuple(
        expression(text, public, f"{key}.{k.name}[{i}]")
        for k in kind.keys
        if isinstance(k, Expressions)
        for i, text in enumerate(values[k.name])
    )
    return _trees(name, terms, along, scope, given, inputs)


def _trees(
    name: str,
    terms: Terms,
    along: Read,
    scope: CaseScope,
    curves: tuple[str, ...],
    inputs: tuple[Node, ...],
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
    return ForceTerms(along, force, states, curves)


def _along(key: str, force: "CoordinateTable", mechanism: "Mechanism") -> Read:
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
