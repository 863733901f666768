"""Readable tables of bodies, markers, joints and force elements."""

from dataclasses import dataclass, field

import numpy as np

from ...math.arrays import Array
from ...math.expressions.program import Node
from ...math.laws import Law
from ...package.body.schema import Invariants, ModalPackage, SecondOrder


@dataclass(frozen=True)
class Body:
    """Inertia and elasticity of one body, in its own frame; rigid if it has no modes."""

    name: str
    invariants: Invariants
    mass: Array  # (m, m) modal mass
    stiffness: Array  # (m, m)
    damping: Array  # (m, m)
    second_order: SecondOrder | None = None  # geometric stiffening; None: a linear body


def rigid_body(name: str, mass: float, centre_B: Array, inertia_B: Array) -> Body:
    """Return a rigid body of given mass, mass centre (3,) and inertia about it (3, 3)."""
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
    """
    second = package.second_order if stiffening else None
    return Body(name, package.invariants, package.mass, package.stiffness, package.damping, second)


@dataclass(frozen=True)
class MarkerTable:
    """One marker: body index (GROUND = -1), rest frame, and its mode shapes."""

    body: int
    x: Array  # (3,) body components; global for the ground [m]
    A: Array = field(default_factory=lambda: np.eye(3))
    phi: Array = field(default_factory=lambda: np.zeros((3, 0)))
    psi: Array = field(default_factory=lambda: np.zeros((3, 0)))
    H: Array | None = None  # (3, m, m) second-order translation, of a stiffened body
    H_psi: Array | None = None  # (3, m, m) second-order rotation vector


@dataclass(frozen=True)
class JointTable:
    """One joint between two markers; kind is a key of `joints.table.KINDS`."""

    name: str
    kind: str
    marker_1: int
    marker_2: int
    law: Law | None = None  # of a drive
    parameters: tuple[float, ...] = ()  # numbers of its kind: joints/contract.py


@dataclass(frozen=True)
class ForceTable:
    """One force element between two markers; kind is a key of `forces.table.KINDS`.

    One that acts along a coordinate is no kind of its own: the coordinate says how it acts.
    """

    name: str
    kind: str
    marker_1: int
    marker_2: int
    parameters: tuple[float, ...] = ()  # numbers of its kind: forces/contract.py
    law: Law | None = None  # of an actuator or a load
    size: Node | None = None  # in place of a law: an expression (quantity_tables.py)
    along: int = -1  # coordinate (quantity_tables.py) that an element of this kind acts along
