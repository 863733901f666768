"""Two-node Timoshenko beam element with exact static interpolation.

Element axes: x1 along the element from node 1, x2 and x3 the section's axes.
Degrees of freedom per node: displacement u1 u2 u3 [m] of the reference line,
rotation f1 f2 f3 [rad] of the section. A point of the section moves by

    u1(x) = u1 + x3 f2 - x2 f3,   u2(x) = u2 - x3 f1,   u3(x) = u3 + x2 f1

(Paper: Eq. (32), Eq. (33), Eq. (34)), hence the generalised strains
e6 = [u1', u2' - f3, u3' + f2, f1', f2', f3'], i.e. e6 = d' - Z d with the
constant nilpotent Z below, and F6 = K e6.

There is no load between the nodes of the element. The resultants follow from
equilibrium, F6(x) = (I + x Q) F6(0) with Q = -Z', the strains are K^-1 F6(x),
and integration gives the displacement as a cubic polynomial of x:

    d(x) = (I + x Z) d(0) + C(x) F6(0),
    C(x) = S x + (Z S + S Q) x^2/2 + Z S Q x^3/6,   S = K^-1.

It includes every coupling of K. There is no locking, because shear and curvature are
not interpolated separately.
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from ...solver.math.arrays import Array

# Effect of section rotation on deflection: u2' contains f3, u3' contains -f2.
Z = np.zeros((6, 6))
Z[1, 5], Z[2, 4] = 1.0, -1.0
# Equilibrium without distributed load: M2' = F3, M3' = -F2.
Q = -Z.T

MASS_POINTS = 4  # N' m N has degree 6 in x: four Gauss points are exact


def scaled_inverse(A: Array) -> Array:
    """Inverse of a symmetric positive definite matrix with rows of different units.

    The entries for slender members differ by many orders of magnitude. Scaling by the
    diagonal first keeps the inverse accurate to round-off.
    """
    scale = 1.0 / np.sqrt(np.diagonal(A))
    inverse = np.linalg.inv(A * np.outer(scale, scale))
    return 0.5 * (inverse + inverse.T) * np.outer(scale, scale)


@dataclass(frozen=True)
class BeamElement:
    """One element in element axes.

    Attributes
    ----------
    length : length L [m]
    K : (6, 6) section stiffness, order extension, shear2, shear3, twist, bend2,
        bend3 [N, N m, N m2]
    """

    length: float
    K: Array

    @cached_property
    def _compliance(self) -> Array:
        return scaled_inverse(self.K)

    def equilibrium(self, x: Array) -> Array:
        """Resultants at `x` from those at node 1: F6(x) = T(x) F6(0).

        Parameters
        ----------
        x : (k,) positions along the element [m]

        Returns
        -------
        (k, 6, 6)
        """
        return np.eye(6) + np.asarray(x)[:, None, None] * Q

    def flexibility(self) -> Array:
        """Deformation energy per resultants at node 1: int_0^L T' K^-1 T dx, (6, 6)."""
        S, L = self._compliance, self.length
        return S * L + (Q.T @ S + S @ Q) * L**2 / 2 + Q.T @ S @ Q * L**3 / 3

    @property
    def _ends(self) -> Array:
        """Forces at both nodes per resultants at node 1, transposed: (6, 12)."""
        return np.hstack([-np.eye(6), np.eye(6) + self.length * Q.T])

    @cached_property
    def _resultants(self) -> Array:
        """Resultants at node 1 per nodal displacements, (6, 12)."""
        # C(L) = T(L)^-T flexibility: only the symmetric matrix has to be inverted.
        return scaled_inverse(self.flexibility()) @ self._ends

    def shape(self, x: Array) -> Array:
        """Shape functions N(x): displacement and rotation per nodal displacements.

        Parameters
        ----------
        x : (k,) positions along the element [m]

        Returns
        -------
        (k, 6, 12) in element axes
        """
        rigid = np.zeros((len(x), 6, 12))
        rigid[:, :, :6] = np.eye(6) + np.asarray(x)[:, None, None] * Z
        S, s = self._compliance, np.asarray(x)[:, None, None]
        # displacement at x per resultants at node 1, node 1 held: C(x)
        C = S * s + (Z @ S + S @ Q) * s**2 / 2 + Z @ S @ Q * s**3 / 6
        return rigid + C @ self._resultants

    def strain(self, x: Array) -> Array:
        """Strain matrix B(x): e6(x) per nodal displacements, (k, 6, 12)."""
        return self._compliance @ self.equilibrium(x) @ self._resultants

    def stiffness(self) -> Array:
        """Element stiffness by the inverse of the flexibility, (12, 12).

        Equal to the integral of Paper: Eq. (35), because the strains are those
        of the exact static solution.
        """
        return self._ends.T @ self._resultants

    def mass_matrix(self, mass: Array, mass_form: str) -> Array:
        """Element mass in the form "consistent", int N' m N dx, or "lumped", (12, 12).

        Lumped: at each node the mass and rotary inertia of the sections of its half of the
        element. Their distance from the node along x1 is neglected.

        Parameters
        ----------
        mass : (6, 6) section mass per length, about the reference line
            [kg/m, kg, kg m]
        """
        if mass_form == "lumped":
            return np.asarray(np.kron(np.eye(2), 0.5 * self.length * mass))
        x, w = gauss(self.length, MASS_POINTS)
        N = self.shape(x)
        M = np.tensordot(w, np.swapaxes(N, 1, 2) @ mass @ N, 1)
        return np.asarray(0.5 * (M + M.T))


_gauss_rule = cache(np.polynomial.legendre.leggauss)


def gauss(length: float, n: int) -> tuple[Array, Array]:
    """Gauss points and weights on [0, length], each (n,) [m]."""
    x, w = _gauss_rule(n)
    return 0.5 * length * (x + 1.0), 0.5 * length * w
