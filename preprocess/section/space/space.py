"""Warping of a section on its mesh: nodes, other unknowns, integration points, strain operators."""

import copy
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array
from ... import fenicsx
from ...fenicsx import NODES
from .numbering import Pattern, lagrange_parts, own_parts
from .section_cells import KINDS, CellMesh, IntArray, full_basis, within
from .strains import fixed, strain_along_beam, strain_in_section
from .unknowns import Unknowns, hanging_unknowns

ALL = slice(None)
AT_A_TIME = 64  # cells per block, so that intermediate arrays stay in the cache


class SectionSpace:
    """Continuous functions on a mesh, and the integration points.

    These data do not depend on the material. By default, `quadrature_degree` is chosen so that E is
    sufficiently accurate. Displacements of the section are flat arrays (n_dof,): unknown by
    unknown the three components (w1, w2, w3). `c` counts cells, `q` the points of a cell, `k` its
    unknowns. In a mesh of triangles and quadrilaterals, or with hanging nodes, cells with fewer
    points or unknowns are filled up with points of zero area and functions that are zero.

    Parameters
    ----------
    mesh : the cells
    degree : of Lagrange functions; None: the functions of the nodes that each cell has
    team : processes that share strains and matrices; each has those of its `own` cells. Loads and
        work are sums over the team

    Attributes
    ----------
    x2, x3 : (n_node,) positions of the nodes [m]
    unknowns : how the values of nodes follow from the unknowns, None if they are the unknowns
    dofs : (c, k) unknowns of each cell
    own : the cells whose functions, strains and matrices this process has; c counts them below
    points : (c, q, 2) positions of the integration points [m]
    weights : (c, q) their areas [m2]
    values : (q, k) or (c, q, k) functions at the points
    gradients : (c, q, 2, k) their derivatives in the section [1/m]
    S_h, S_l : (6, 6) and (6, 3) strains G_h w of the slopes of w and G_l w of its values
    """

    def __init__(
        self,
        mesh: CellMesh,
        degree: int | None = 2,
        quadrature_degree: int | None = None,
        team: fenicsx.Team = fenicsx.ALONE,
    ) -> None:
        self.mesh, self.team = mesh, team
        self.own = team.share(mesh.n_cell)
        self._given, self.degree = degree, mesh.degree if degree is None else degree
        # curved cells need two degrees more than straight ones; with the functions of the nodes,
        # every cell has the usual rule of its kind: 3 x 3 points with middle nodes, 2 x 2 without
        curved = degree is not None and mesh.degree > 1 and mesh.is_curved
        self.quadrature_degree = quadrature_degree or 2 * self.degree + (2 if curved else 0)
        P = None
        if degree is None:
            parts, n_node = own_parts(mesh)
        else:
            parts, n_node, P = lagrange_parts(mesh, degree)
        self.rules = [  # the parts, with points and weights of integration on the reference cell
            (
                part,
                fenicsx.quadrature(
                    KINDS[part.kind],
                    2
                    if degree is None and quadrature_degree is None and part.is_linear
                    else self.quadrature_degree,
                ),
            )
            for part in parts
        ]
        c, q = mesh.n_cell, max(len(weights) for _, (_, weights) in self.rules)
        k = max(part.nodes.shape[1] for part in parts)
        self.dofs = np.empty((c, k), dtype=np.int32)
        first, stop = self.own.start, self.own.stop
        points, areas = np.empty((stop - first, q, 2)), np.zeros((stop - first, q))
        self.values: Array = np.zeros((q, k) if len(parts) == 1 else (stop - first, q, k))
        self.gradients = np.zeros((stop - first, q, 2, k))
        places = np.empty((n_node, 2))
        for part, (reference, weights) in self.rules:
            rows, (p, n) = part.rows, (len(weights), part.nodes.shape[1])
            self.dofs[rows, :n], self.dofs[rows, n:] = part.nodes, part.nodes[:, :1]
            places[part.nodes] = part.places()
            mine = np.flatnonzero(within(rows, self.own))
            if not len(mine):
                continue
            rows = rows[mine] - first
            x, functions = part.map(reference, mine), part.functions(reference, mine)
            points[rows, :p], points[rows, p:] = x[..., :2], x[:, :1, :2]
            areas[rows, :p] = weights * np.abs(x[..., 2])
            if len(parts) == 1:
                self.values[:] = functions[0, :, 0]
            else:
                self.values[rows, :p, :n] = functions[:, :, 0]
            self.gradients[rows, :p, :, :n] = functions[:, :, 1:]
        self.points, self.weights = team.stacked(points), team.stacked(areas)
        self.x2, self.x3 = places.T.copy()
        self.S_h, self.S_l = fixed(strain_in_section)[:, 3:], fixed(strain_along_beam)[:, :3]
        self.unknowns: Unknowns | None = None
        self.over: Unknowns | None = None  # the last change of `expressed`
        self._finish()
        if P is not None:
            self._express(hanging_unknowns(P))

    def _finish(self) -> None:
        self.n_unknown = len(self.x2) if self.unknowns is None else self.unknowns.P.shape[1]
        self._to_nodes = self._summing(self.dofs[self.own])

    def _summing(self, dofs: IntArray) -> sp.csr_matrix:
        """Matrix (n_unknown, c k) that sums contributions of cells, of dofs (c, k)."""
        places = dofs.ravel(), np.arange(dofs.size)
        return sp.csr_matrix((np.ones(dofs.size), places), shape=(self.n_unknown, dofs.size))

    def _express(self, unknowns: Unknowns) -> None:
        """Change to unknowns that give the present ones."""
        dofs, parts = unknowns.of_cells(self.dofs.astype(np.int64))
        self.dofs = dofs.astype(np.int32)
        parts = parts[self.own]
        self.gradients = self.gradients @ parts[:, None]
        values = self.values if self.values.ndim == 3 else self.values[None]
        self.values = values @ parts
        self.unknowns = unknowns if self.unknowns is None else self.unknowns.then(unknowns)
        self._finish()

    def copied(self) -> "SectionSpace":
        """A copy without what follows from its functions."""
        other = copy.copy(self)
        for name in ("pattern", "weighted_gradients", "_products"):
            other.__dict__.pop(name, None)
        return other

    def expressed(self, unknowns: Unknowns) -> "SectionSpace":
        """The same functions with other unknowns, which give the present ones."""
        other = self.copied()
        other._express(unknowns)
        other.over = unknowns
        return other

    def with_rule(self, quadrature_degree: int) -> "SectionSpace":
        """The same functions and unknowns at the points of another rule."""
        other = SectionSpace(self.mesh, self._given, quadrature_degree, self.team)
        return other if self.over is None else other.expressed(self.over)

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return self.mesh.n_cell

    @property
    def n_dof(self) -> int:
        """Number of unknowns of the warping, three each."""
        return 3 * self.n_unknown

    @property
    def area(self) -> float:
        """Area of the section [m2]."""
        return float(self.weights.sum())

    @property
    def _areas(self) -> Array:
        """Areas of the points of the own cells, (c, q) [m2]."""
        return self.weights[self.own]

    @cached_property
    def pattern(self) -> Pattern:
        """Sparsity pattern of every matrix of the own cells."""
        return Pattern(self.dofs[self.own], self.n_unknown)

    @cached_property
    def weighted_gradients(self) -> Array:
        """Derivatives times the areas of their points, (c, k, 2 q), columns (q, alpha)."""
        c, q, _, k = self.gradients.shape
        weighted = self._areas[..., None, None] * self.gradients
        return np.ascontiguousarray(np.swapaxes(weighted.reshape(c, 2 * q, k), 1, 2))

    def E(self, C: Array) -> sp.csr_matrix:
        """<G_h, C G_h> [Pa] for C (c, 1, 6, 6), constant in each cell, or (c, q, 6, 6) [Pa].

        Each of several processes has the E of its own cells, whose sum is that of the section.
        """
        pattern = self.pattern
        if C.shape[1] > 1:
            return pattern.matrix(pattern.data(self._blocks(C)))
        by_slopes = self._by_slopes(C[:, 0])
        return pattern.matrix(pattern.ordered(self._products @ by_slopes.reshape(-1, 9)))

    @cached_property
    def _products(self) -> sp.csr_matrix:
        """The part of E that depends only on the mesh, for one stiffness in each cell.

        Of each cell the integrals of d_alpha phi_i d_beta phi_j, (k^2, 4): row k i + j is the pair
        of nodes, column 2 alpha + beta.
        """
        c, q, _, k = self.gradients.shape
        slopes = self.gradients.reshape(c, q, 2 * k)
        left = self.weighted_gradients.reshape(c, k, q, 2).swapaxes(2, 3)
        products = left.reshape(c, 2 * k, q) @ slopes  # (c, i alpha, beta j)
        products = products.reshape(c, k, 2, 2, k).transpose(0, 1, 4, 2, 3)
        return self.pattern.summed(products.reshape(c, k * k, 4))

    def _blocks(self, C: Array) -> Array:
        """Element matrices (c, k^2, 9) with a stiffness at every point, (c, q, 6, 6)."""
        gradients, weighted = self.gradients, self.weighted_gradients
        c, q, _, k = gradients.shape
        blocks = np.empty((c, k, 9 * k))
        for first in range(0, c, AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            # stress in direction alpha at a point from the displacement of each node
            stress = np.swapaxes(gradients[some], 2, 3)[:, :, None] @ self._by_slopes(C[some])
            blocks[some] = weighted[some] @ stress.reshape(-1, 2 * q, 9 * k)
        return blocks.reshape(c, k * k, 9)

    def _by_slopes(self, C: Array) -> Array:
        """S' C S: stiffness of a and b for pairs of slopes alpha, beta, (..., 2, 2, 3 a + b)."""
        S = self.S_h.reshape(6, 2, 3)
        both = np.einsum("rxa,syb->rsxyab", S, S).reshape(36, 36)
        return np.asarray(C.reshape(*C.shape[:-2], 36) @ both).reshape(*C.shape[:-2], 2, 2, 9)

    def displacements(self, *fields: tuple[Any, Any, Any]) -> Array:
        """Unknowns of fields (w1, w2, w3), each a number or (n_node,), as columns."""
        kind = np.result_type(float, *(c for field in fields for c in field))
        out = np.zeros((self.x2.size, 3, len(fields)), dtype=kind)
        for column, components in enumerate(fields):
            for i, component in enumerate(components):
                out[:, i, column] = component
        if self.unknowns is not None:
            out = self.unknowns.of_nodes(out)
        return out.reshape(self.n_dof, len(fields))

    def unknowns_at_nodes(self) -> tuple[IntArray, Array]:
        """Unknowns that are displacements of nodes, (w,), and their positions (w, 2) [m]."""
        x = np.stack([self.x2, self.x3], axis=1)
        if self.unknowns is None:
            return np.arange(self.n_unknown), x
        return self.unknowns.whole, x[self.unknowns.at]

    def layer_angles(self) -> Array:
        """Angle of the layer direction of the mesh at the points, (c, q) [deg]."""
        angles = self.mesh.layer_angle
        assert angles is not None
        out = np.zeros(self.weights.shape)
        out[:] = angles[:, :1]
        if angles.shape[1] > 1:
            for part, (reference, _) in self.rules:
                values = full_basis(part.kind, reference)[0]
                out[part.rows, : len(values)] = angles[part.rows, : values.shape[1]] @ values.T
        return out

    def at_points(self, W: Array) -> Array:
        """Values of displacement columns (n_dof, m) at the points, (c, q, 3, m)."""
        nodal = self._of_cells(W)
        return (self.values @ nodal).reshape(*self._areas.shape, 3, -1)

    def strain_in_section(self, W: Array) -> Array:
        """G_h W at the points, (c, q, 6, m), for displacement columns W (n_dof, m)."""
        return self.S_h @ self.slopes(W)

    def strain_along_beam(self, W: Array) -> Array:
        """G_l W at the points, (c, q, 6, m): the strain due to a change W per x1."""
        return self.S_l @ self.at_points(W)

    def slopes(self, W: Array) -> Array:
        """Derivatives d w_a / d x_alpha at the points, (c, q, 6, m), rows 3 alpha + a."""
        c, q = self._areas.shape
        slope = self.gradients.reshape(c, 2 * q, -1) @ self._of_cells(W)
        return slope.reshape(c, q, 6, -1)

    # Loads of some `cells` are those of stresses that are zero in all others.

    def load_of_slopes(self, partner: Array, cells: Any = ALL) -> Array:
        """Integral of partner . slopes of w for each unknown of w, (n_dof, m)."""
        weighted = self.weighted_gradients[cells]
        return self._sum(weighted @ partner.reshape(len(weighted), weighted.shape[2], -1), cells)

    def load_in_section(self, stress: Array, cells: Any = ALL) -> Array:
        """Integral of (G_h w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        return self.load_of_slopes(self.S_h.T @ stress, cells)

    def load_along_beam(self, stress: Array, cells: Any = ALL) -> Array:
        """Integral of (G_l w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        return self.load(self.S_l.T @ stress, cells)

    def load(self, traction: Array, cells: Any = ALL) -> Array:
        """Integral of w . traction for each unknown of w, (n_dof, m), traction (c, q, 3, m)."""
        areas = self._areas[cells]
        weighted = areas[..., None, None] * traction
        values = self.values if self.values.ndim == 2 else self.values[cells]
        of_cells = np.swapaxes(values, -1, -2) @ weighted.reshape(*areas.shape, -1)
        return self._sum(of_cells, cells)

    def work(self, stress: Array, strain: Array, cells: Any = ALL) -> Array:
        """Integral of stress' strain over cells, (m, n).

        Parameters
        ----------
        stress : (c, q, 6, m) at the points
        strain : (c, q, 6, n)
        cells : rows of the c cells
        """
        weighted = self._areas[cells][..., None, None] * stress
        return self.team.total(
            weighted.reshape(-1, stress.shape[3]).T @ strain.reshape(-1, strain.shape[3])
        )

    def _of_cells(self, W: Array) -> Array:
        """Unknowns cell by cell, (c, k, 3 m)."""
        return W.reshape(self.n_unknown, -1)[self.dofs[self.own]]

    def _sum(self, of_cells: Array, cells: Any = ALL) -> Array:
        """Loads (n_dof, m) from the contributions of the cells (c, k, 3 m)."""
        to_nodes = self._to_nodes if cells is ALL else self._summing(self.dofs[self.own][cells])
        total = to_nodes @ of_cells.reshape(-1, of_cells.shape[-1])
        return self.team.total(total).reshape(self.n_dof, -1)

    def at_corners_and_middles(self, W: Array) -> list[Array]:
        """Values of displacement columns (n_dof, m) at the 6 or 9 nodes of the map of each cell.

        One array (c, 6 or 9, 3, m) for each kind in mesh.of_kinds.
        """
        m = W.shape[1]
        nodal = W.reshape(self.n_unknown, 3 * m)
        if self.unknowns is not None:
            nodal = self.unknowns.at_nodes(nodal)
        out = []
        for kind, rows in self.mesh.of_kinds:
            reference = NODES[KINDS[kind]] / 2.0
            values = np.empty((self.n_cell, len(reference), 3 * m))
            for part, _ in self.rules:
                if part.kind == kind:
                    values[part.rows] = part.values(reference) @ nodal[part.nodes]
            out.append(values[rows].reshape(len(rows), len(reference), 3, m))
        return out
