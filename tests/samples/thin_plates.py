"""Thin rectangular plates of symmetric plies, and their best lay-ups that are known.

Load factors of simply supported plates in closed form, and frequencies by Ritz's method.
"""

from typing import Any

import numpy as np
import scipy.linalg
from numpy.polynomial import legendre
from samples.laminate_samples import reference

from plymotion.solver.package.common.materials import Orthotropic
from plymotion.solver.package.shell.plies import PATTERNS, harmonics, ply_factors

BEST = reference("best-lay-ups.toml")
INCH = 0.0254
POUND_PER_INCH = 4.4482216152605 / INCH  # [N/m]
PLY = 0.005 * INCH
STEPS = [0, 45, -45, 90]
E1, E2, _, NU = BEST["materials"]["narita"].values()
D0 = E2 / (12.0 * (1.0 - NU**2 * E2 / E1))  # of the plies of Narita, per h^3


def constants(name: str) -> dict[str, float]:
    """A material of the table, across the plies as in their plane."""
    E1, E2, G, nu = (BEST["materials"][name][key] for key in ("E1", "E2", "G12", "nu12"))
    plane = {"E1": E1, "E2": E2, "E3": E2, "G12": G, "G13": G, "G23": G}
    return plane | {"nu12": nu, "nu13": nu, "nu23": nu, "rho": 1500.0}


def parameters(plies: Any) -> Any:
    """Lamination parameters (4,) of bending of plies from the outside to the middle."""
    share = np.diff(np.arange(len(plies) + 1.0) ** 3) / len(plies) ** 3
    return share @ harmonics(np.array(plies[::-1]))


def bending(name: str, h: float, xi: Any) -> Any:
    """D (3, 3) of lamination parameters (4,)."""
    (mean,), (factors,) = ply_factors([Orthotropic(**constants(name))])
    return h**3 / 12.0 * (mean + np.tensordot(factors * xi, PATTERNS, 1))


def load_factors(D: Any, a: float, b: float, ratio: float) -> Any:
    """Of Nx = 1 lb/in and Ny = ratio Nx on a simply supported plate, by half waves each way.

    D16 and D26 have no part.
    """
    m, n = np.meshgrid(np.arange(1.0, 13.0), np.arange(1.0, 13.0))
    x, y = (np.pi * m / a) ** 2, (np.pi * n / b) ** 2
    work = D[0, 0] * x**2 + 2.0 * (D[0, 1] + 2.0 * D[2, 2]) * x * y + D[1, 1] * y**2
    return work / (x + ratio * y) / POUND_PER_INCH


class Square:
    """A square of polynomials (1 - x^2)^held P_i(x), as many each way: 1 at supported edges, 2 at
    clamped ones. The vibration of the plies of Narita."""

    def __init__(self, held: int, count: int) -> None:
        x, w = legendre.leggauss(count + 5)
        shape = legendre.legpow([2.0 / 3.0, 0.0, -2.0 / 3.0], held)
        rows = [legendre.legmul(shape, np.eye(count)[i]) for i in range(count)]
        f = [np.array([legendre.legval(x, legendre.legder(r, d)) for r in rows]) for d in range(3)]
        one = [[(f[i] * w) @ f[j].T for j in range(3)] for i in range(3)]
        self.M = np.kron(one[0][0], one[0][0])
        # second derivatives xx, yy, 2 xy, of a side of 1: x in -1 < x < 1
        orders = ((2, 0, 4.0), (0, 2, 4.0), (1, 1, 8.0))
        self.K = np.array([
            [s * t * np.kron(one[i][k], one[j][n]) for k, n, t in orders] for i, j, s in orders
        ])  # fmt: skip

    def frequency(self, plies: Any) -> float:
        """w a^2 sqrt(rho h / D0)."""
        K = np.tensordot(bending("narita", 1.0, parameters(plies)) / D0, self.K, 2)
        return float(np.sqrt(scipy.linalg.eigvalsh(K, self.M, subset_by_index=[0, 0])[0]))
