"""Strain operators of a cross-section and the matrices E, H, L made of them.

A displacement w(x1, x2, x3) of the section's points has the three-dimensional
strain G_h w + G_l w', a dash meaning d/dx1: G_h holds the derivatives within the
section, G_l those along the beam. With the stiffness C of each point,

    E = <G_h, C G_h>,   H = <G_h, C G_l>,   L = <G_l, C G_l>

(the paper's C_hh = E, C_hl and C_ll). The material is a coefficient, one 6x6 per
cell, so one set of compiled forms serves every material and lay-up on a mesh.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.package.schema import Array
from .. import fenicsx
from ..fenicsx import ufl
from .mesh import MeshRequest, generate

DEGREE = 2  # of the warping field; not below the degree of the geometry
QUADRATURE_DEGREE = 2 * DEGREE + 2  # curved cells need two more than straight ones


def strain_in_section(w: Any) -> Any:
    """G_h w in the order 11, 22, 33, 23, 13, 12 with engineering shear (UFL)."""
    dw = ufl.grad(w)
    return ufl.as_vector([0.0, dw[1, 0], dw[2, 1], dw[1, 1] + dw[2, 0], dw[0, 1], dw[0, 0]])


def strain_along_beam(w: Any) -> Any:
    """G_l w in the same order: the strain that a change of w along x1 makes (UFL)."""
    return ufl.as_vector([w[0], 0.0, 0.0, 0.0, w[2], w[1]])


@dataclass(frozen=True)
class SectionMatrices:
    """E, H, L of one material distribution, (n_dof, n_dof), on one sparsity pattern."""

    E: sp.csr_matrix  # [Pa]
    H: sp.csr_matrix  # [Pa m]
    L: sp.csr_matrix  # [Pa m2]


class SectionSpace:
    """Mesh, degree-2 warping space and compiled forms: all that no material changes.

    Displacements of the section are flat arrays (n_dof,): node by node the three components
    (w1, w2, w3).
    """

    def __init__(self, labelled: fenicsx.LabelledMesh) -> None:
        self.labelled = labelled
        mesh = labelled.mesh
        space = fenicsx.vector_space(mesh, DEGREE, 3)
        self.x2, self.x3 = fenicsx.dof_coordinates(space)[:, :2].T
        self.stiffness = fenicsx.function(fenicsx.cell_space(mesh, (6, 6)))
        dx = ufl.dx(domain=mesh, metadata={"quadrature_degree": QUADRATURE_DEGREE})
        test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
        h_test, h_trial = strain_in_section(test), strain_in_section(trial)
        l_test, l_trial = strain_along_beam(test), strain_along_beam(trial)
        C = self.stiffness
        self._E, self._H, self._L = fenicsx.compile_forms(
            [
                ufl.inner(h_test, C * h_trial) * dx,
                ufl.inner(h_test, C * l_trial) * dx,
                ufl.inner(l_test, C * l_trial) * dx,
            ]
        )
        self.factor: fenicsx.Cholesky | None = None  # symbolic part kept between materials

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return self.labelled.n_cell

    @property
    def n_dof(self) -> int:
        """Number of unknowns of the warping, three per node."""
        return 3 * int(self.x2.size)

    def matrices(self, C_cells: Array) -> SectionMatrices:
        """Assemble E, H, L for a stiffness per cell, (n_cell, 6, 6) [Pa]."""
        fenicsx.set_cell_values(self.stiffness, C_cells)
        E, H, L = (fenicsx.assemble(form) for form in (self._E, self._H, self._L))
        return SectionMatrices(E, H, L)

    def gram(self, weight: Array) -> sp.csr_matrix:
        """Inner product of displacements, integral of weight u.v, for a weight per cell."""
        select = np.diag([1.0, 0.0, 0.0, 0.0, 1.0, 1.0])  # |G_l u|^2 = |u|^2
        fenicsx.set_cell_values(self.stiffness, weight[:, None, None] * select)
        return fenicsx.assemble(self._L)

    @cached_property
    def area_gram(self) -> sp.csr_matrix:
        """Inner product of displacements over the area [m2]."""
        return self.gram(np.ones(self.n_cell))

    def displacements(self, *fields: tuple[Any, Any, Any]) -> Array:
        """Nodal values of fields (w1, w2, w3), each a number or (n_node,), as columns."""
        out = np.zeros((self.x2.size, 3, len(fields)))
        for column, components in enumerate(fields):
            for i, component in enumerate(components):
                out[:, i, column] = component
        return out.reshape(self.n_dof, len(fields))


@lru_cache(maxsize=16)
def section_space(request: MeshRequest) -> SectionSpace:
    """The space on a mesh; kept in the process, so that every material on it is cheap."""
    return SectionSpace(generate(request))
