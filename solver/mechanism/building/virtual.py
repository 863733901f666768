"""Virtual bodies: rigid bodies that constraints fix to an interface of a body.

Massless ones stand between an interface of a flexible body and its joints.

The paper (section 2.2) writes joints between rigid bodies only. Six constraints fix a virtual body
to the interface, and the joint is attached to the virtual body. A marker has the same six
equations substituted (solver/dynamics/elements/bodies/marker.py), so both give the same motion. A
virtual body has twelve more unknowns for every interface: six coordinates and six multipliers.

The mass matrix is then singular, but the saddle-point matrix is not: the motion of a virtual body
follows from its flexible body by the six constraints, and M is positive definite on all motions
that the constraints allow.

A point mass that is much heavier than its body is a virtual body as well. As a part of the body it
would be in its mass matrix, which turns with the body's frame: Newton's matrix of an implicit step,
frozen at one orientation, then misses the mass ratio times the rotation within the step, and the
iteration diverges. The force between the body and the virtual body is an unknown of the iteration.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...dynamics.model.model import GROUND, Model
from ...math.arrays import Array
from ..assembly.tables import Body, JointTable, MarkerTable, rigid_body

HEAVY = 1e3  # a point mass over its body, from which on it is a virtual body


@dataclass(frozen=True)
class VirtualBodies:
    """Tables of a mechanism, with virtual bodies after the others."""

    bodies: list[Body]  # the virtual ones
    markers: list[MarkerTable]  # all; those of the mechanism keep their numbers
    joints: list[JointTable]  # all; those of the mechanism keep their numbers
    carriers: list[tuple[int, Array]] = field(default_factory=list)  # body, position (3,) in it [m]

    def frames(self, r: Array, A: Array) -> list[tuple[Array, Array]]:
        """Return the positions of the virtual bodies for frames r (nb, 3), A (nb, 3, 3) at rest."""
        return [(r[body] + A[body] @ x, A[body]) for body, x in self.carriers]

    def scaled(self, model: Model) -> Model:
        """Return the model with the inertia of the carriers as scale of the virtual bodies."""
        if not self.carriers:
            return model
        scale = model.inertia_scale.copy()
        first = model.n_body - len(self.carriers)
        for k, (body, _) in enumerate(self.carriers):
            i, j = int(model.vel_start[body]), int(model.vel_start[first + k])
            if model.mass[first + k] == 0.0:
                scale[j : j + 3] = scale[i : i + 3]
            scale[j + 3 : j + 6] = scale[i + 3 : i + 6]
        return model._replace(inertia_scale=scale)

    def with_masses(
        self, bodies: Sequence[Body], names: Sequence[str], masses: Sequence[tuple[int, float]]
    ) -> "VirtualBodies":
        """Return the tables with each mass (marker, [kg]) as a virtual body, fixed to its marker.

        `bodies` are those of the mechanism without virtual ones.
        """
        found = VirtualBodies([*self.bodies], [*self.markers], [*self.joints], [*self.carriers])
        for name, (k, mass) in zip(names, masses, strict=True):
            found.add(name, mass, self.markers[k], len(bodies) + len(found.bodies))
        return found

    def add(self, name: str, mass: float, marker: MarkerTable, number: int) -> None:
        """Append a virtual body of a mass [kg], body `number` of the model, fixed to a marker."""
        self.bodies.append(rigid_body(name, mass, np.zeros(3), np.zeros((3, 3))))
        self.carriers.append((marker.body, marker.x))
        self.markers.extend([replace(marker, A=np.eye(3)), MarkerTable(number, np.zeros(3))])
        last = len(self.markers) - 1
        self.joints.append(JointTable(name, "fixed", last - 1, last))


def through_virtual_bodies(
    bodies: Sequence[Body], markers: Sequence[MarkerTable], joints: Sequence[JointTable]
) -> VirtualBodies:
    """Return the tables with every joint end on a flexible body moved to a virtual body.

    All joints of one interface share a virtual body, as in section 2.2 of the paper.
    """
    found = VirtualBodies([], [*markers], [])
    number: dict[tuple[int, bytes, bytes], int] = {}  # interface -> its virtual body
    moved: dict[int, int] = {}  # marker on a flexible body -> marker on its virtual body

    def on_virtual_body(k: int) -> int:
        marker = markers[k]
        if marker.body == GROUND or not bodies[marker.body].mass.size:
            return k
        if k not in moved:
            interface = (marker.body, marker.x.tobytes(), marker.phi.tobytes())
            if interface not in number:
                number[interface] = len(bodies) + len(found.bodies)
                name = f"{bodies[marker.body].name} (virtual {len(found.bodies) + 1})"
                found.add(name, 0.0, marker, number[interface])
            found.markers.append(MarkerTable(number[interface], np.zeros(3), marker.A))
            moved[k] = len(found.markers) - 1
        return moved[k]

    own = [
        replace(j, marker_1=on_virtual_body(j.marker_1), marker_2=on_virtual_body(j.marker_2))
        for j in joints
    ]
    return replace(found, joints=own + found.joints)
