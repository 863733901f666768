"""Input of a shell to the mode computation: reference condition, static loads, order of nodes.

Modes are computed in the independent degrees of freedom: six of each node that is not in a rigid
interface, and six of the reference point of each rigid interface.
"""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.plain_data import SpecError, expected
from ... import fenicsx
from ...modes.reduced import StaticLoad, accelerations
from ...modes.reference import HELD, Algebra, Condition, HeldDofs, MeanAxis
from ..analyses.frequencies import TOLERANCE
from ..model.links import Link
from ..model.shell_problem import ShellProblem
from ..shell_cells import DOFS
from .interfaces import SAME_PLACE, ShellBodySpec, nodal_mass

ALONG = 1e-6  # sine of the angle between a chord and the x axis


def _solve(A: object, B: Array, definite: bool = True) -> Array:
    factor = fenicsx.Cholesky(A, definite=definite)
    try:
        return factor.solve(B)
    finally:
        factor.close()


MUMPS = Algebra(_solve, fenicsx.negative_pivots, partial(_solve, definite=False))
eigen_solver = partial(fenicsx.eigenpairs, tolerance=TOLERANCE)


@dataclass(frozen=True)
class ShellModel:
    """A shell with the requests of its body specification."""

    spec: ShellBodySpec
    problem: ShellProblem

    def check(self) -> None:
        """Raise SpecError for a shell of several parts, or with mechanisms."""
        rigid, drilling = self.problem.free_motions(self.problem.freedom)
        if len(rigid) > 6:
            raise SpecError("shell: it consists of unconnected parts; expected one body")
        if drilling:
            raise SpecError(
                "shell.elements.drilling: nodes of a flat part can rotate about its normal; "
                'expected "tie" or "auto"'
            )

    @property
    def carriers(self) -> tuple[int, ...]:
        """Numbers of the interfaces that carry the frame."""
        return tuple(round(number) for _, number in self.spec.reference.places)

    @cached_property
    def independent_nodes(self) -> IntArray:
        """Node, or number of nodes plus that of the link, of each six independent unknowns."""
        return np.asarray(self.problem.freedom.free[::DOFS] // DOFS)

    def link_dofs(self, number: int) -> IntArray:
        """The six degrees of freedom of an interface, among all."""
        return DOFS * (self.problem.mesh.n_node + number) + np.arange(DOFS)

    @cached_property
    def condition(self) -> Condition:
        """The reference condition.

        Raises
        ------
        SpecError : a chord that is not along x
        ModeError : a mean axis of a body without inertia about some axis.
        """
        problem, freedom = self.problem, self.problem.freedom
        K, M = freedom.reduced(problem.K), freedom.reduced(problem.M)
        kind = self.spec.reference.kind
        if kind == "mean-axis":
            return MeanAxis(K, M, freedom.rigid_motions()[freedom.free], MUMPS)
        if kind == "chord":
            self._check_chord()
        dofs = zip(self.carriers, HELD[kind], strict=True)
        held = [self.link_dofs(n)[list(own)] for n, own in dofs]
        return HeldDofs(K, M, np.searchsorted(freedom.free, np.concatenate(held)), MUMPS)

    def _check_chord(self) -> None:
        first, second = (self.problem.links[number] for number in self.carriers)
        along = second.point_G - first.point_G
        length = np.linalg.norm(along)
        one_place = length <= SAME_PLACE * self.problem.mesh.size
        if one_place or np.linalg.norm(along[1:]) > ALONG * length:
            known = "two interfaces on a line along the body's x, which a chord frame's x axis is"
            shown = f"{first.name} at {_point(first)} and {second.name} at {_point(second)}"
            raise SpecError(expected("reference.at", shown, known))

    def static_loads(self) -> list[StaticLoad]:
        """Loads of the requested static modes."""
        places, names = self._places_B - self.origin_B, list(self.spec.interfaces)
        return self.spec.modes.static_loads(self._unit_forces(), names, places[:, 0], places)

    def _unit_forces(self) -> Array:
        """Unit forces and moments at the interfaces, on the independent dofs, (n_free, 6 i)."""
        freedom, count = self.problem.freedom, len(self.spec.interfaces)
        at = [dof for number in range(count) for dof in self.link_dofs(number).tolist()]
        forces = np.zeros((freedom.n_dof, len(at)))
        forces[at, np.arange(len(at))] = 1.0
        return np.asarray(freedom.gathered(forces))

    def unit_loads(self) -> Array:
        """Unit loads (n_free, l) of the compliance of a package: of interfaces, and inertia."""
        return np.hstack([self._unit_forces(), self.condition.M @ self.unit_accelerations()])

    def unit_accelerations(self) -> Array:
        """Accelerations (n_free, 12) of the inertia among the unit loads."""
        places = np.repeat(self._places_B, DOFS, axis=0)
        return accelerations(places, np.arange(len(places)) % DOFS)

    @cached_property
    def origin_B(self) -> Array:
        """Position of the frame: its first interface, or the origin."""
        if not self.carriers:
            return np.zeros(3)
        return self.problem.links[self.carriers[0]].point_G

    @cached_property
    def _places_B(self) -> Array:
        ends = [link.point_G[None] for link in self.problem.links]
        every = np.concatenate([self.problem.mesh.points_G, *ends])
        return np.asarray(every[self.independent_nodes])

    def far_to_near(self) -> IntArray:
        """Independent nodes in descending distance from the frame, then in the order of the
        mesh file."""
        mesh = self.problem.mesh
        distance = np.linalg.norm(self._places_B - self.origin_B, axis=1)
        steps = np.round(distance / (SAME_PLACE * mesh.size))
        return np.lexsort([self.independent_nodes, -steps])

    @cached_property
    def nodal_mass(self) -> tuple[Array, Array]:
        """Lumped mass of the mesh's nodes, (n,), and inertia about them, (n, 3, 3)."""
        return nodal_mass(self.problem.mesh, self.problem.regions, self.problem.stiffeners)

    def participation(self, columns: Array) -> Array:
        """Modal mass by kind of motion, (4, m, m), with lumped masses of the nodes.

        In the order of `modes.KINDS`: motion along y, along z, zero, along x.
        """
        problem, (mass, _) = self.problem, self.nodal_mass
        u = problem.freedom.expanded(columns)[: DOFS * problem.mesh.n_node]
        u = u.reshape(problem.mesh.n_node, DOFS, columns.shape[1])
        x, y, z = (u[:, a].T @ (mass[:, None] * u[:, a]) for a in range(3))
        return np.array([y, z, np.zeros_like(x), x])


def _point(link: Link) -> str:
    return "({:.6g}, {:.6g}, {:.6g})".format(*link.point_G)
