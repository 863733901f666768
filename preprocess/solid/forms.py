"""Elasticity of a solid in three dimensions, as weak forms.

Strain columns have the order 11, 22, 33, 23, 13, 12 with engineering shear strains.
"""

from typing import Any

import ufl

# Polynomial degrees that are integrated exactly for displacements of degree 2: with four points in
# a tetrahedron, as in other codes, and 27 in a hexahedron; one degree more of u adds two. The mass
# is exact where edges are straight.
STIFFNESS_DEGREE = {"tetrahedron": 2, "hexahedron": 4}
MASS_DEGREE = 5


def stiffness_rule(cell: str, degree: int) -> int:
    """Degree of the integration of the stiffness for displacements of a degree."""
    return STIFFNESS_DEGREE[cell] + 2 * (degree - 2)


class Elasticity:
    """Stresses of strains: C (6, 6), a UFL coefficient in the axes of the body.

    `rule` is the degree of the integration.
    """

    def __init__(self, C: Any, rule: int) -> None:
        self.C = C
        self._dx = ufl.dx(metadata={"quadrature_degree": rule})

    def work(self, one: Any, other: Any) -> Any:
        """Work of the stresses of one strain (3, 3) on another."""
        return ufl.inner(self.C * column(one), column(other)) * self._dx

    def stiffness(self, space: Any) -> Any:
        """Work of the stresses of u on the strains of v."""
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
        return self.work(strain(u), strain(v))


def column(e: Any) -> Any:
    """Column of strains (3, 3)."""
    return ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])


def strain(u: Any) -> Any:
    """Linear strains of a displacement, (3, 3)."""
    return ufl.sym(ufl.grad(u))


def pressure(space: Any, over: Any) -> Any:
    """Work of a unit pressure on the undeformed faces of a measure, inwards."""
    return -ufl.dot(ufl.FacetNormal(space.mesh), ufl.TestFunction(space)) * over


def mass(space: Any, rho: Any, degree: int = MASS_DEGREE) -> Any:
    """Work of the inertia forces rho u on v.

    Parameters
    ----------
    space : of the displacements
    rho : density of the cells [kg/m3]
    degree : polynomial degree that is integrated exactly
    """
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    return rho * ufl.inner(u, v) * ufl.dx(metadata={"quadrature_degree": degree})
