"""Elasticity of a solid in three dimensions, as weak forms.

Strain columns have the order 11, 22, 33, 23, 13, 12 with engineering shear strains.
"""

from typing import Any

import ufl

# Four points in a tetrahedron, as in other codes; 27 in a hexahedron. The mass is exact where
# edges are straight.
STIFFNESS_DEGREE = {"tetrahedron": 2, "hexahedron": 4}
MASS_DEGREE = 5


def strain(u: Any) -> Any:
    """Linear strains of a displacement, a column of six."""
    return column(ufl.sym(ufl.grad(u)))


def column(e: Any) -> Any:
    """A symmetric tensor of strain as a column of six."""
    return ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])


def stiffness(space: Any, C: Any, cell: str) -> Any:
    """Work of the stresses C eps(u) on the strains of v."""
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    dx = ufl.dx(metadata={"quadrature_degree": STIFFNESS_DEGREE[cell]})
    return ufl.inner(C * strain(u), strain(v)) * dx


def mass(space: Any, rho: Any, degree: int = MASS_DEGREE) -> Any:
    """Work of the inertia forces rho u on v, with integration exact for a polynomial degree."""
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    return rho * ufl.inner(u, v) * ufl.dx(metadata={"quadrature_degree": degree})
