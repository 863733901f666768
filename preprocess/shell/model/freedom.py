"""Free degrees of freedom: supports and links eliminated, u = T q; flat nodes; rigid motions."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ....solver.math.arrays import Array, IntArray
from ....solver.package.specification import SHELL_LINK_KINDS
from ...modes.reference import principal
from ..shell_cells import DOFS, ShellError, ShellMesh
from .links import Link, averaged, carried
from .regions import Region
from .stiffeners import Stiffener
from .supports import COMPONENTS, Support

FLAT = np.sin(np.radians(1.0)) ** 2  # relative second moment of the normals about their mean


class FlatNodes(NamedTuple):
    """Nodes (k,) with the normals (k, 3) about which they do not rotate."""

    nodes: IntArray
    normals_G: Array


def flat_nodes(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener] = ()
) -> FlatNodes:
    """Nodes with all cells in one plane to within one degree, without a stiffener.

    Parameters
    ----------
    mesh : of the shell
    regions : all of its cells, with their axes
    stiffeners : on curves of the mesh
    """
    table = np.zeros((mesh.n_node, 3, 3))
    for region in regions:
        n = region.geometry.A_GE[:, :, 2]
        np.add.at(table, region.nodes, (n[:, :, None] * n[:, None, :])[:, None])
    value, axis = np.linalg.eigh(table)
    flat = value[:, 1] < FLAT * value[:, 2]
    for stiffener in stiffeners:
        flat[stiffener.ends] = False
    return FlatNodes(np.flatnonzero(flat), axis[flat, :, 2])


def dependent_rotations(flat: FlatNodes, fixed: Array) -> tuple[IntArray, IntArray, Array]:
    """Dependence of one rotation of each flat node on its other two.

    Parameters
    ----------
    fixed : (n_dof,) bool, fixed degrees of freedom

    Returns
    -------
    (k,) dependent degrees of freedom, (k, 2) the degrees of freedom that determine them, (k, 2)
    factors. Nodes with supports that prevent the rotation are omitted.
    """
    rotations = 6 * flat.nodes[:, None] + np.arange(3, 6)  # (k, 3)
    share = np.where(fixed[rotations], 0.0, np.abs(flat.normals_G))
    last = np.argmax(share, axis=1)
    row = np.arange(len(last))
    some = share[row, last] > 0.1
    row, last = row[some], last[some]
    others = (last[:, None] + np.array([1, 2])) % 3
    n = flat.normals_G[row]
    pick = np.arange(len(row))
    factors = -np.take_along_axis(n, others, axis=1) / n[pick, last][:, None]
    return rotations[row, last], np.take_along_axis(rotations[row], others, axis=1), factors


FREE = 1e-9  # singular value of the supports' rows below which a rigid motion is free


class Freedom:
    """The independent degrees of freedom of a shell, and which of them are free."""

    def __init__(
        self,
        mesh: ShellMesh,
        links: Sequence[Link] = (),
        supports: Sequence[Support] = (),
        flat: FlatNodes | None = None,
    ) -> None:
        self.mesh, self.links, self.supports = mesh, tuple(links), tuple(supports)
        self.n_dof = DOFS * (mesh.n_node + len(links))
        self.fixed = np.unique(np.concatenate([np.zeros(0, int), *(s.dofs for s in supports)]))
        held = np.zeros(self.n_dof, dtype=bool)
        held[self.fixed] = True
        # all degrees of freedom from the independent ones, with zero columns for the others
        self._T, self._dependent = _followed(mesh, self.links, self.n_dof, flat, held)
        independent = np.ones(self.n_dof, dtype=bool)
        independent[self._dependent] = False
        self._check_fixed(independent)
        free = independent.copy()
        free[self.fixed] = False
        self.free = np.flatnonzero(free)

    @property
    def n_free(self) -> int:
        """Number of unknowns."""
        return len(self.free)

    def reduced(self, A: sp.csr_matrix) -> sp.csr_matrix:
        """T' A T of a symmetric A, (n_free, n_free).

        Without stored zeros: a part in a coordinate plane then is two problems of half the size.
        """
        own, dependent = principal(A, self.free), self._dependent
        if not len(dependent):
            return own
        # few dofs are dependent: all other rows of T are rows of the unit matrix
        C = self._T[dependent][:, self.free]
        rows = A[dependent]
        across = C.T @ rows[:, self.free]
        out = sp.csr_matrix(own + across + across.T + C.T @ (rows[:, dependent] @ C))
        out.eliminate_zeros()
        return out

    def gathered(self, forces: Array) -> Array:
        """T' f of forces on all degrees of freedom, (n_free, k)."""
        return np.asarray((self._T.T @ forces)[self.free])

    def expanded(self, q: Array) -> Array:
        """Displacements of all degrees of freedom, (n_dof, k), from the free ones."""
        u = np.zeros((self.n_dof, q.shape[1]))
        u[self.free] = q
        return np.asarray(self._T @ u)

    def carried_along(self, given: Array) -> Array:
        """Displacements of all degrees of freedom, (n_dof, k), from those given of fixed ones."""
        return np.asarray(self._T @ given)

    def on_supports(self, forces: Array) -> Array:
        """Forces of the nodes on the fixed degrees of freedom, (n_dof, k), zero elsewhere."""
        forces = self._T.T @ forces
        out = np.zeros_like(forces)
        out[self.fixed] = forces[self.fixed]
        return out

    def rigid_motions(self) -> Array:
        """Three translations and three rotations about the mesh's centre, (n_dof, 6) [m, rad]."""
        mesh = self.mesh
        ends = [link.point_G[None] for link in self.links]
        points = np.concatenate([mesh.points_G, *ends])
        return carried(points - mesh.points_G.mean(axis=0)).reshape(self.n_dof, 6)

    def parts(self) -> IntArray:
        """Number of the connected part (by cells and links) of each node and reference point,
        (n,)."""
        mesh, n = self.mesh, self.n_dof // DOFS
        pairs = [mesh.edges.nodes]
        for row, link in enumerate(self.links):
            nodes = link.group.nodes
            pairs.append(np.stack([nodes, np.full(len(nodes), mesh.n_node + row)], axis=1))
        ends = np.concatenate(pairs)
        graph = sp.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
        return np.asarray(connected_components(graph, directed=False)[1])

    def free_rigid_motions(self) -> list[Array]:
        """Rigid motions of each part that no support prevents, as (n_dof,) columns of norm 1."""
        rigid, parts = self.rigid_motions(), np.repeat(self.parts(), DOFS)
        size = max(self.mesh.size, 1e-300)
        scale = np.array([1.0, 1.0, 1.0, 1.0 / size, 1.0 / size, 1.0 / size])
        weight = np.tile([1.0, 1.0, 1.0, size, size, size], self.n_dof // DOFS)
        motions_kept = []
        for part in range(parts.max() + 1):
            motions = np.where((parts == part)[:, None], rigid, 0.0) * scale
            held = (motions * weight[:, None])[self.fixed[parts[self.fixed] == part]]
            _, value, axes = np.linalg.svd(
                np.concatenate([held, np.zeros((6, 6))]), full_matrices=False
            )
            free = _plain_basis(axes[value <= FREE * max(1.0, value[0])])
            motions_kept += [motions @ axis for axis in free]
        return motions_kept

    def describe(self, motion: Array) -> str:
        """Description of a rigid motion: along or about which axis."""
        rows = motion.reshape(-1, 6)
        row = int(np.argmax(np.abs(rows).max(axis=1)))
        displacement, turn = rows[row, :3], rows[row, 3:]
        if np.linalg.norm(turn) * self.mesh.size <= 1e-6 * np.linalg.norm(displacement):
            return f"translation along {_axis(displacement)}"
        points = self.mesh.points_G
        place = points[row] if row < len(points) else self.links[row - len(points)].point_G
        centre = place + np.cross(turn, displacement) / (turn @ turn)
        centre = np.where(np.abs(centre) < FREE * self.mesh.size, 0.0, centre)
        at = "({:.4g}, {:.4g}, {:.4g})".format(*centre)
        return f"rotation about {_axis(turn)} through {at}"

    def _check_fixed(self, independent: Array) -> None:
        wrong = self.fixed[~independent[self.fixed]]
        if not wrong.size:
            return
        support = next(s for s in self.supports if np.isin(wrong[0], s.dofs))
        raise ShellError(
            f"supports.{support.name}: fixes {COMPONENTS[wrong[0] % DOFS]} of a node of a "
            "rigid link; support the link instead (at = its name)"
        )


def _plain_basis(rows: Array) -> Array:
    """Basis of the same space in echelon form: each row has a 1 in a column of its own."""
    own: list[int] = []
    for column in range(rows.shape[1] if len(rows) else 0):
        if np.linalg.matrix_rank(rows[:, [*own, column]], tol=1e-6) > len(own):
            own.append(column)
    basis = np.linalg.solve(rows[:, own], rows)
    return np.where(np.abs(basis) < 1e-9, 0.0, basis)


def _followed(
    mesh: ShellMesh, links: Sequence[Link], n_dof: int, flat: FlatNodes | None, held: Array
) -> tuple[sp.csr_matrix, IntArray]:
    """T (n_dof, n_dof), and the dependent degrees of freedom."""
    T = sp.identity(n_dof, format="csr")
    dependent = [np.zeros(0, dtype=np.int64)]
    if flat is not None:
        carried_nodes = [link.group.nodes for link in links if link.kind == "rigid"]
        own = ~np.isin(flat.nodes, np.concatenate([np.zeros(0, int), *carried_nodes]))
        last, others, factors = dependent_rotations(
            FlatNodes(flat.nodes[own], flat.normals_G[own]), held
        )
        T = _replaced(T, last[:, None], others, factors)
        dependent.append(last)
    # rigid links first: an average may be taken over nodes that one of them carries
    for number in sorted(range(len(links)), key=lambda n: SHELL_LINK_KINDS.index(links[n].kind)):
        link = links[number]
        nodes = DOFS * link.group.nodes[:, None] + np.arange(DOFS)  # (k, 6)
        reference = DOFS * (mesh.n_node + number) + np.arange(DOFS)
        arms = mesh.points_G[link.group.nodes] - link.point_G
        if link.kind == "rigid":
            T = _replaced(T, nodes[:, :, None], reference, carried(arms))
            dependent.append(nodes.ravel())
        else:
            block = averaged(arms, link.group.weights) if link.rows is None else link.rows
            T = _replaced(T, reference[:, None, None], nodes, block)
            dependent.append(reference)
    return T, np.concatenate(dependent)


def _replaced(T: sp.csr_matrix, rows: IntArray, columns: IntArray, values: Array) -> sp.csr_matrix:
    """T with some of its rows replaced by sums of others, by arrays of one shape (broadcast)."""
    keep = np.ones(T.shape[0])
    keep[rows] = 0.0
    places = [np.broadcast_to(part, values.shape).ravel() for part in (rows, columns)]
    sums = sp.csr_matrix((values.ravel(), places), shape=T.shape)
    return sp.csr_matrix((sp.diags(keep) + sums) @ T)


def _axis(direction: Array) -> str:
    unit = direction / np.linalg.norm(direction)
    # the first of the largest components, equal to round-off, is positive
    unit = unit * np.sign(unit[np.argmax(np.abs(unit) > 0.999 * np.abs(unit).max())])
    for name, row in zip("xyz", np.eye(3), strict=True):
        if np.allclose(unit, row, atol=1e-6):
            return name
    return "({:.3g}, {:.3g}, {:.3g})".format(*np.where(np.abs(unit) < 1e-6, 0.0, unit))
