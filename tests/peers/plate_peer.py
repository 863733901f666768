"""A second route to flat laminates: Ritz series of first-order theory in Legendre polynomials.

Load factors of buckling under an even prestress, and flap frequencies of a cantilever that spins
about a normal of its plane, with the membrane resultants of the spin from the same series. The work
of the prestress is that on w only. It reads nothing of the finite elements.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy.linalg
from numpy.polynomial import legendre

U, V, W, X, Y = range(5)
# fields of the eight strains (e, k, gamma): field, derivatives by x and y
STRAINS = [
    [(U, (1, 0))], [(V, (0, 1))], [(U, (0, 1)), (V, (1, 0))],
    [(X, (1, 0))], [(Y, (0, 1))], [(X, (0, 1)), (Y, (1, 0))],
    [(W, (1, 0)), (X, (0, 0))], [(W, (0, 1)), (Y, (0, 0))],
]  # fmt: skip


def along(n: int, held: Sequence[bool], x: Any) -> tuple[Any, Any]:
    """n polynomials on -1 < x < 1 that vanish at held ends, and their derivatives, (n, q)."""
    factor = legendre.leg2poly([1.0])
    for end, sign in zip(held, (1.0, -1.0), strict=True):
        factor = np.polymul(factor, [sign, 1.0]) if end else factor
    rows = [np.polymul(legendre.leg2poly(np.eye(n)[i])[::-1], factor) for i in range(n)]
    return (
        np.array([np.polyval(row, x) for row in rows]),
        np.array([np.polyval(np.polyder(row), x) for row in rows]),
    )


class Plate:
    """Rectangle 0 < x < a, -b/2 < y < b/2.

    Parameters
    ----------
    C : stiffness (8, 8) of the strains above, [A B 0; B D 0; 0 0 Ds]
    held : whether each field (U, V, W, X, Y) is held at x = 0, x = a, y = -b/2, y = b/2
    """

    def __init__(self, C: Any, a: float, b: float, held: Mapping[int, Any], n: int = 10) -> None:
        g, weight = legendre.leggauss(n + 5)
        self.weight = np.kron(weight, weight) * a * b / 4.0
        self.x, self.y = np.repeat(0.5 * a * (g + 1.0), len(g)), np.tile(0.5 * b * g, len(g))
        self.size = n * n
        self.parts = []
        for field in range(5):
            fx, fy = along(n, held[field][:2], g), along(n, held[field][2:], g)
            self.parts.append({
                (i, j): np.kron(fx[i], fy[j]) * (2.0 / a) ** i * (2.0 / b) ** j
                for i, j in ((0, 0), (1, 0), (0, 1))
            })  # fmt: skip
        self.C = C
        self.strain = np.zeros((8, 5 * self.size, len(self.weight)))
        for row, terms in enumerate(STRAINS):
            for field, slope in terms:
                self.strain[row, self.of(field)] += self.parts[field][slope]
        B = self.strain
        pairs = [(i, j) for i in range(8) for j in range(8) if C[i, j]]
        self.K = sum(C[i, j] * (B[i] * self.weight) @ B[j].T for i, j in pairs)

    def of(self, field: int) -> slice:
        return slice(field * self.size, (field + 1) * self.size)

    def geometric(self, N: Any) -> Any:
        """Kg of resultants (Nxx, Nyy, Nxy), numbers or values at the points."""
        gx, gy = self.parts[W][1, 0], self.parts[W][0, 1]
        Kg = np.zeros_like(self.K)
        shear = (gx * self.weight * N[2]) @ gy.T
        Kg[self.of(W), self.of(W)] = (gx * self.weight * N[0]) @ gx.T + shear + shear.T
        Kg[self.of(W), self.of(W)] += (gy * self.weight * N[1]) @ gy.T
        return Kg

    def first_factor(self, N: Sequence[float]) -> float:
        """The smallest load factor above 0."""
        return float(1.0 / scipy.linalg.eigvalsh(-self.geometric(N), self.K)[-1])

    def spinning(self, rho: float, h: float, spin: float, hub: float) -> Any:
        """Frequencies [rad/s] with w of a cantilever, x = 0 at a distance from the axis."""
        f = np.zeros(len(self.K))
        at = {U: self.x + hub, V: self.y}
        for field, r in at.items():
            f[self.of(field)] = self.parts[field][0, 0] @ (self.weight * rho * h * spin**2 * r)
        strain = np.einsum("ikp,k->ip", self.strain, np.linalg.solve(self.K, f))
        K = self.K + self.geometric(self.C[:3] @ strain)
        M = np.zeros_like(K)
        for field, m in zip(range(5), [rho * h] * 3 + [rho * h**3 / 12.0] * 2, strict=True):
            part = self.parts[field][0, 0]
            M[self.of(field), self.of(field)] = m * (part * self.weight) @ part.T
        return np.sqrt(scipy.linalg.eigvalsh(K, M)[:2])
