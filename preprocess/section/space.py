"""Warping of a section on its mesh: nodes, integration points, strain operators.

A displacement w(x1, x2, x3) of the section's points has the three-dimensional
strain G_h w + G_l w', with ' for d/dx1. G_h has the derivatives within the
section, G_l those along the beam.
"""

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from .. import fenicsx
from .pattern import Pattern

# Row of the strain (11, 22, 33, 23, 13, 12) to which each derivative d w_a / d x_alpha contributes,
# in the order (a, alpha) = 1,2  1,3  2,2  2,3  3,2  3,3; and the same for each w_a'.
IN_SECTION = [5, 4, 1, 3, 3, 2]
ALONG_BEAM = [0, 5, 4]
BY_SLOPE = [5, 1, 3, 4, 3, 2]  # IN_SECTION in the order 3 alpha + a
SLOPE = [0, 1, 5, 4, 3, 0]  # inverse map: row 11 has no entry, row 23 has two


class SectionSpace:
    """Continuous Lagrange functions of a degree on a mesh, and the integration points.

    These data do not depend on the material. By default, `quadrature_degree` is chosen so that E is
    sufficiently accurate. Displacements of the section are flat arrays (n_dof,): node by
    node the three components (w1, w2, w3). `c` counts cells, `q` the points of a cell, `k` its
    nodes.

    Attributes
    ----------
    x2, x3 : (n_node,) positions of the nodes [m]
    dofs : (c, k) nodes of each cell
    points : (c, q, 2) positions of the integration points [m]
    weights : (c, q) their areas [m2]
    values : (q, k) functions at the points
    gradients : (c, q, 2, k) their derivatives in the section [1/m]
    """

    def __init__(
        self, labelled: fenicsx.LabelledMesh, degree: int = 2, quadrature_degree: int | None = None
    ) -> None:
        mesh = labelled.mesh
        cell = fenicsx.cell_name(mesh)
        nodes, cells, geometry_degree = fenicsx.geometry(mesh)
        self.labelled, self.degree, self.cell = labelled, degree, cell
        space = fenicsx.vector_space(mesh, degree, 3)
        self.x2, self.x3 = fenicsx.dof_coordinates(space)[:, :2].T.copy()
        self.dofs = fenicsx.cell_dofs(space)

        # curved cells need two degrees more than straight ones
        corners = np.ascontiguousarray(nodes[:, :2])[cells]
        curved = geometry_degree > 1 and is_curved(corners, cell)
        self.quadrature_degree = quadrature_degree or 2 * degree + (2 if curved else 0)
        reference, weights = fenicsx.quadrature(cell, self.quadrature_degree)
        values, slopes = fenicsx.basis(cell, geometry_degree, reference)
        self.points = values @ corners
        jacobian = np.einsum("cka,qkg->cqag", corners, slopes, optimize=True)
        determinant = (
            jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
        )
        self.weights = weights * np.abs(determinant)
        inverse = np.empty_like(jacobian)  # d xi_g / d x_a
        inverse[..., 0, 0], inverse[..., 1, 1] = jacobian[..., 1, 1], jacobian[..., 0, 0]
        inverse[..., 0, 1], inverse[..., 1, 0] = -jacobian[..., 0, 1], -jacobian[..., 1, 0]
        inverse /= determinant[..., None, None]
        self.values, slopes = fenicsx.basis(cell, degree, reference)
        by_slope = np.moveaxis(slopes, -1, 0)[:, :, None]  # (2, q, 1, k)
        self.gradients = inverse[:, :, 0, :, None] * by_slope[0]
        self.gradients += inverse[:, :, 1, :, None] * by_slope[1]
        k = self.dofs.shape[1]
        # (n_node, c k): sums the contributions of the cells at each node
        self._to_nodes = sp.csr_matrix(
            (np.ones(self.dofs.size), (self.dofs.ravel(), np.arange(self.dofs.size))),
            shape=(self.x2.size, self.n_cell * k),
        )

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return int(self.dofs.shape[0])

    @property
    def n_dof(self) -> int:
        """Number of unknowns of the warping, three per node."""
        return 3 * int(self.x2.size)

    @property
    def area(self) -> float:
        """Area of the section [m2]."""
        return float(self.weights.sum())

    @cached_property
    def pattern(self) -> Pattern:
        """Sparsity pattern of every matrix on this space."""
        return Pattern(self.dofs, self.x2.size)

    @cached_property
    def weighted_gradients(self) -> Array:
        """Derivatives times the areas of their points, (c, k, 2 q), columns (q, alpha)."""
        c, q, _, k = self.gradients.shape
        weighted = self.weights[..., None, None] * self.gradients
        return np.ascontiguousarray(np.swapaxes(weighted.reshape(c, 2 * q, k), 1, 2))

    def displacements(self, *fields: tuple[Any, Any, Any]) -> Array:
        """Nodal values of fields (w1, w2, w3), each a number or (n_node,), as columns."""
        out = np.zeros((self.x2.size, 3, len(fields)))
        for column, components in enumerate(fields):
            for i, component in enumerate(components):
                out[:, i, column] = component
        return out.reshape(self.n_dof, len(fields))

    def at_points(self, W: Array) -> Array:
        """Values of displacement columns (n_dof, m) at the points, (c, q, 3, m)."""
        nodal = self._of_cells(W)
        return (self.values @ nodal).reshape(*self.weights.shape, 3, -1)

    def strain_in_section(self, W: Array) -> Array:
        """G_h W at the points, (c, q, 6, m), for displacement columns W (n_dof, m)."""
        c, q = self.weights.shape
        slope = self.gradients.reshape(c, 2 * q, -1) @ self._of_cells(W)
        slope = slope.reshape(c, q, 6, -1)  # rows 3 alpha + a
        strain = np.take(slope, SLOPE, axis=2)
        strain[:, :, 0] = 0.0
        strain[:, :, 3] += slope[:, :, 2]  # d w3 / d x2
        return strain

    def strain_along_beam(self, W: Array) -> Array:
        """G_l W at the points, (c, q, 6, m): the strain due to a change W per x1."""
        strain = np.zeros((*self.weights.shape, 6, W.shape[1]))
        strain[:, :, ALONG_BEAM] = self.at_points(W)
        return strain

    def load_in_section(self, stress: Array) -> Array:
        """Integral of (G_h w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        c, q, _, m = stress.shape
        # rows (q, alpha), columns (a, m): the stress that works on d w_a / d x_alpha
        partner = np.take(stress, BY_SLOPE, axis=2).reshape(c, 2 * q, 3 * m)
        return self._sum(self.weighted_gradients @ partner)

    def load_along_beam(self, stress: Array) -> Array:
        """Integral of (G_l w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        return self.load(np.take(stress, ALONG_BEAM, axis=2))

    def load(self, traction: Array) -> Array:
        """Integral of w . traction for each unknown of w, (n_dof, m), traction (c, q, 3, m)."""
        weighted = self.weights[..., None, None] * traction
        return self._sum(self.values.T @ weighted.reshape(*self.weights.shape, -1))

    def work(self, stress: Array, strain: Array) -> Array:
        """Integral of stress' strain over the section, (m, n), of (c, q, 6, m) and (c, q, 6, n)."""
        weighted = self.weights[..., None, None] * stress
        return np.asarray(
            weighted.reshape(-1, stress.shape[3]).T @ strain.reshape(-1, strain.shape[3])
        )

    def _of_cells(self, W: Array) -> Array:
        """Nodal values cell by cell, (c, k, 3 m)."""
        return W.reshape(self.x2.size, -1)[self.dofs]

    def _sum(self, of_cells: Array) -> Array:
        """Loads (n_dof, m) from the contributions of the cells (c, k, 3 m)."""
        columns = of_cells.shape[-1]
        return (self._to_nodes @ of_cells.reshape(-1, columns)).reshape(self.n_dof, -1)


def is_curved(corners: Array, cell: str) -> bool:
    """True unless the middle nodes of degree-2 cells lie half way between corners.

    `corners` (c, k, 2) are the nodes of the cells in DOLFINx's order.
    """
    ends = {
        "triangle": {3: (1, 2), 4: (0, 2), 5: (0, 1)},
        "quadrilateral": {4: (0, 1), 5: (0, 2), 6: (1, 3), 7: (2, 3)},
    }[cell]
    size = np.abs(corners.max(axis=1) - corners.min(axis=1)).max(axis=1)
    for middle, (a, b) in ends.items():
        off = corners[:, middle] - 0.5 * (corners[:, a] + corners[:, b])
        if np.any(np.abs(off).max(axis=1) > 1e-9 * size):
            return True
    return False
