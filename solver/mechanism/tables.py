"""Readable tables of bodies, markers, joints, force elements and of what expressions read."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..dynamics.elements.forces.table import LOADS
from ..dynamics.model.model import ANGLE, N_POLAR, N_ROTOR, N_SHAPE, Quantities, Rotor
from ..math.arrays import Array, IntArray
from ..math.expressions.program import Node, new_stack, programs
from ..math.laws import Law
from ..math.records import record
from ..package.body.package_schema import Invariants, ModalPackage, SecondOrder


class Body(NamedTuple):
    """Inertia and elasticity of one body, in its own frame; rigid if it has no modes."""

    name: str
    invariants: Invariants
    mass: Array  # (m, m) modal mass
    stiffness: Array  # (m, m)
    damping: Array  # (m, m)
    second_order: SecondOrder | None = None  # geometric stiffening; None: a linear body


def rigid_body(name: str, mass: float, centre_B: Array, inertia_B: Array) -> Body:
    """Return a rigid body of given mass, mass centre (3,) and inertia about it (3, 3).

    Parameters
    ----------
    name : name of the body
    mass : mass [kg]
    centre_B : mass centre (3,) in body axes [m]
    inertia_B : inertia (3, 3) about the mass centre, body axes [kg m2]
    """
    centre = np.asarray(centre_B, dtype=float)
    empty = np.zeros((0, 0))
    invariants = Invariants(
        mass=mass,
        S0_B=mass * centre,
        S_B=np.zeros((3, 0)),
        T00_B=mass * np.outer(centre, centre),
        T01_B=np.zeros((3, 3, 0)),
        T11_B=np.zeros((3, 3, 0, 0)),
        J0_B=np.asarray(inertia_B, dtype=float),
        J_psi_B=np.zeros((3, 0)),
        mass_form="lumped",
    )
    return Body(name, invariants, empty, empty, empty)


def flexible_body(name: str, package: ModalPackage, *, stiffening: bool = False) -> Body:
    """Return the body that a modal package describes, of second order with `stiffening`.

    A package without second-order data always gives a linear body.

    Parameters
    ----------
    name : name of the body
    package : its modal package
    stiffening : with second-order terms
    """
    second = package.second_order if stiffening else None
    return Body(name, package.invariants, package.mass, package.stiffness, package.damping, second)


@record
class MarkerTable:
    """One marker: body index (GROUND = -1), rest frame, and its mode shapes."""

    body: int
    x: Array  # (3,) body components; global for the ground [m]
    A: Array = field(default_factory=lambda: np.eye(3))
    phi: Array = field(default_factory=lambda: np.zeros((3, 0)))
    psi: Array = field(default_factory=lambda: np.zeros((3, 0)))
    H: Array | None = None  # (3, m, m) second-order translation, of a stiffened body
    H_psi: Array | None = None  # (3, m, m) second-order rotation vector


class JointTable(NamedTuple):
    """One joint between two markers; kind is a key of `joints.table.KINDS`."""

    name: str
    kind: str
    marker_1: int
    marker_2: int
    law: Law | None = None  # of a drive
    parameters: tuple[float, ...] = ()  # numbers of its kind: joints/contract.py


class ForceTable(NamedTuple):
    """One force element between two markers; kind is a key of `forces.table.KINDS`.

    One that acts along a coordinate is no kind of its own: the coordinate says how it acts.
    """

    name: str
    kind: str
    marker_1: int
    marker_2: int
    parameters: tuple[float, ...] = ()  # numbers of its kind: forces/contract.py
    law: Law | None = None  # of an actuator or a load
    size: Node | None = None  # in place of a law: an expression
    along: int = -1  # coordinate that an element of this kind acts along

    @property
    def is_its_size(self) -> bool:
        """Whether the force is `size` times a direction: along a coordinate, or a load."""
        return self.along >= 0 or self.kind in LOADS


class RotorTable(NamedTuple):
    """A rotor before its loads, laws and states have numbers."""

    forces: tuple[ForceTable, ...]
    laws: tuple[Law, Law]  # speed [m/s] and turn of the direction [rad]
    polar: IntArray
    shape: Array
    polars: Array
    numbers: Array
    state: int


def rotor_arrays(rotor: RotorTable | None, n_force: int, first_law: int) -> Rotor:
    """Return the arrays of the model, with the rotor's loads last among `n_force` elements.

    Parameters
    ----------
    rotor : table of the rotor, if there is one
    n_force : number of force elements of the model
    first_law : number of the law of the wind speed; that of its direction follows
    """
    section = np.full(n_force, -1, dtype=np.int64)
    if rotor is None:
        none = np.zeros(0, dtype=np.int64)
        shape, polars = np.zeros((0, N_SHAPE)), np.zeros((0, 2, N_POLAR))
        return Rotor(section, none, shape, polars, np.zeros(N_ROTOR), np.full(2, -1), 0)
    n = len(rotor.polar)
    section[n_force - n :] = np.arange(n)
    law = np.array([first_law, first_law + 1], dtype=np.int64)
    return Rotor(section, rotor.polar, rotor.shape, rotor.polars, rotor.numbers, law, rotor.state)


# What an expression of the model reads: "value" or "rate" of a coordinate, "state", "reaction" or
# "curve", with its number.
Quantity = tuple[str, int]
MOST_FEEDBACK = 32  # forces in Newton's matrix by a rank of their own: their cost is the square


class CoordinateTable(NamedTuple):
    """A coordinate of two markers; `kind` and `axes` as in model/model.py."""

    kind: int
    marker_1: int
    marker_2: int
    axes: tuple[int, ...] = ()
    offset: float = 0.0  # value at which it is zero [m, rad]
    first: float = 0.0  # value near which an angle over many turns starts [rad]


class StateTable(NamedTuple):
    """An auxiliary state.

    Attributes
    ----------
    name : for messages
    rate : expression of its rate; None: constant
    start : expression of its value at the start, of coordinates and earlier states
    scale : size, for the tolerance of its error
    update : expression of its value from an instant on, every `period` [s] from t = 0 on
    inputs : of a function outside of the model that gives this value in place of `update`
    owner : force that it belongs to
    event : coordinate, level and direction (1 up, -1 down) at whose passage it takes `update`
    """

    name: str
    rate: Node | None
    start: Node
    scale: float = 1.0
    update: Node | None = None
    period: float = 0.0
    inputs: Sequence[Node] | None = None
    owner: str = ""
    event: tuple[int, float, float] | None = None


class CouplingRow(NamedTuple):
    """One equation between coordinates: the sum of ratio times value is zero.

    unit : d distance [m], r angle [rad]
    """

    name: str
    unit: str
    terms: tuple[tuple[int, float], ...]  # coordinate and its ratio


@dataclass(eq=False, repr=False)
class Measured:
    """Coordinates, states, curves and sizes of reactions of a model, as they are added.

    Of a reaction: number of the joint, kind (model/model.py).
    """

    coordinates: list[CoordinateTable] = field(default_factory=list)
    states: list[StateTable] = field(default_factory=list)
    curves: list[Law] = field(default_factory=list)
    couplings: list[CouplingRow] = field(default_factory=list)
    reactions: list[tuple[int, int]] = field(default_factory=list)

    def coordinate(self, table: CoordinateTable) -> int:
        """Return the number of a coordinate; one that is there already is not added again."""
        if table not in self.coordinates:
            self.coordinates.append(table)
        return self.coordinates.index(table)

    def state(self, table: StateTable) -> int:
        """Add a state; return its number."""
        self.states.append(table)
        return len(self.states) - 1

    def curve(self, law: Law) -> int:
        """Add a curve; return its number."""
        self.curves.append(law)
        return len(self.curves) - 1

    def reaction(self, joint: int, kind: int) -> int:
        """Return the number of a size of a reaction; it is not added twice."""
        if (joint, kind) not in self.reactions:
            self.reactions.append((joint, kind))
        return self.reactions.index((joint, kind))

    @property
    def markers(self) -> list[int]:
        """Markers of the coordinates."""
        return [k for c in self.coordinates for k in (c.marker_1, c.marker_2)]


def quantities_of(
    measured: Measured, laws: Sequence[Law], forces: Sequence[ForceTable]
) -> Quantities:
    """Return the arrays.

    Parameters
    ----------
    laws : of time; those that are expressions are taken from here
    forces : force elements
    """
    coordinates, n = measured.coordinates, len(measured.coordinates)
    sizes = [force.size for force in forces]
    states = measured.states
    nodes = [law.expression for law in laws] + sizes + [s.rate for s in states]
    nodes += [s.start for s in states] + [s.update for s in states]
    called = [j for j, s in enumerate(states) if s.inputs is not None]
    inputs = [node for j in called for node in states[j].inputs or ()]
    used = [*(node for node in nodes if node is not None), *inputs]
    number = iter(range(len(used)))
    numbers = [next(number) if node is not None else -1 for node in nodes]
    n_law, n_state = len(laws), len(states)
    ends = np.cumsum([n_law, len(sizes), n_state, n_state, n_state])
    terms = [term for row in measured.couplings for term in row.terms]
    read: set[Hashable] = {leaf.quantity for node in used for leaf in node.leaves()}
    read |= {("value", m) for m, _ in terms}
    turning = [m for m, c in enumerate(coordinates) if c.kind == ANGLE and ("value", m) in read]
    turn = np.full(n, -1, dtype=np.int64)
    turn[turning] = n_state + np.arange(len(turning))
    behind_states = 2 * n + n_state + len(turning)

    coupled = [
        (k, j)
        for k, force in enumerate(forces)
        if force.along >= 0
        for j in sorted(j for kind, j in _read(force.size) if kind == "state")
        if states[j].rate is not None
    ]

    events = [(j, state.event) for j, state in enumerate(states) if state.event is not None]
    feedback, fed = _feedback(forces, states, coupled)

    def place(quantity: Hashable) -> int:
        assert isinstance(quantity, tuple)
        kind, k = quantity
        return {
            "value": 2 * k,
            "rate": 2 * k + 1,
            "state": 2 * n + k,
            "reaction": behind_states + k,
            "curve": k,
        }[kind]

    return Quantities(
        kind=np.array([c.kind for c in coordinates], dtype=np.int64),
        marker=np.array(measured.markers, dtype=np.int64).reshape(n, 2),
        axes=np.array([(*c.axes, 0, 0, 0, 0)[:4] for c in coordinates], dtype=np.int64).reshape(
            n, 4
        ),
        offset=np.array([c.offset for c in coordinates], dtype=float),
        turn=turn,
        rate=np.array([*numbers[ends[1] : ends[2]], *[-1] * len(turning)], dtype=np.int64),
        of_coordinate=np.array([*[-1] * n_state, *turning], dtype=np.int64),
        start=np.array([*[0.0] * n_state, *(coordinates[m].first for m in turning)]),
        start_expression=np.array(
            [*numbers[ends[2] : ends[3]], *[-1] * len(turning)], dtype=np.int64
        ),
        update=np.array([*numbers[ends[3] : ends[4]], *[-1] * len(turning)], dtype=np.int64),
        period=np.array([*(s.period for s in states), *[0.0] * len(turning)], dtype=float),
        scale=np.array([*(s.scale for s in states), *[np.inf] * len(turning)]),
        programs=programs(used, place, measured.curves),
        law=np.array(numbers[:n_law], dtype=np.int64),
        force=np.array(numbers[n_law : ends[1]], dtype=np.int64),
        along=np.array([force.along for force in forces], dtype=np.int64),
        coupled_force=np.array([k for k, _ in coupled], dtype=np.int64),
        coupled_state=np.array([j for _, j in coupled], dtype=np.int64),
        called=np.array(called, dtype=np.int64),
        call_start=len(used)
        - len(inputs)
        + np.cumsum([0, *(len(states[j].inputs or ()) for j in called)], dtype=np.int64),
        coupling_start=np.cumsum(
            [0, *(len(row.terms) for row in measured.couplings)], dtype=np.int64
        ),
        coupling_coordinate=np.array([m for m, _ in terms], dtype=np.int64),
        coupling_ratio=np.array([ratio for _, ratio in terms], dtype=float),
        reaction_joint=np.array([joint for joint, _ in measured.reactions], dtype=np.int64),
        reaction_kind=np.array([kind for _, kind in measured.reactions], dtype=np.int64),
        reacting=np.array(
            [k for k, force in enumerate(forces) if _reacts(force.size)], dtype=np.int64
        ),
        feedback=np.array(feedback, dtype=np.int64),
        fed_row=np.array([row for row, _ in fed], dtype=np.int64),
        fed_coordinate=np.array([m for _, m in fed], dtype=np.int64),
        event_state=np.array([j for j, _ in events], dtype=np.int64),
        event_coordinate=np.array([event[0] for _, event in events], dtype=np.int64),
        event_level=np.array([event[1] for _, event in events], dtype=float),
        event_sign=np.array([event[2] for _, event in events], dtype=float),
        end=np.inf,
        stack=new_stack(used),
    )


def _read(node: Node | None) -> set[Quantity]:
    """Return the quantities and curves of the model that an expression reads."""
    leaves = node.leaves() if node is not None else ()
    return {leaf.quantity for leaf in leaves if isinstance(leaf.quantity, tuple)}


def _feedback(
    forces: Sequence[ForceTable],
    states: Sequence[StateTable],
    coupled: Sequence[tuple[int, int]],
) -> tuple[list[int], list[tuple[int, int]]]:
    """Return `feedback`, and pairs of `fed_row` and `fed_coordinate`; none of too many forces."""
    reading = {k: _others(e.size, e.along) for k, e in enumerate(forces) if e.is_its_size}
    behind = [_others(states[j].rate, forces[k].along) for k, j in coupled]
    inputs = [
        k
        for k, others in reading.items()
        if others
        or _reacts(forces[k].size)
        or any(m for (force, _), m in zip(coupled, behind, strict=True) if force == k)
    ]
    if len(inputs) > MOST_FEEDBACK:
        inputs = [k for k in inputs if forces[k].along >= 0]  # loads are left to the iteration
    if not 0 < len(inputs) <= MOST_FEEDBACK:
        return [], []
    pairs = [(i, m) for i, k in enumerate(inputs) for m in reading[k]]
    pairs += [(len(inputs) + p, m) for p, others in enumerate(behind) for m in others]
    return inputs, pairs


def _others(node: Node | None, along: int) -> list[int]:
    """Return the coordinates that an expression reads, without `along`."""
    return sorted({k for kind, k in _read(node) if kind in ("value", "rate")} - {along})


def _reacts(size: Node | None) -> bool:
    """Return whether an expression reads a reaction."""
    return any(kind == "reaction" for kind, _ in _read(size))


def reads_motion(size: Node | None) -> bool:
    """Return whether a force along a coordinate depends on coordinates, states or reactions."""
    return any(kind != "curve" for kind, _ in _read(size))
