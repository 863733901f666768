"""A brick of trilinear elements with consistent mass: matrices for tests of imported bodies."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp

from plymotion.solver.math.arrays import Array, IntArray

GAUSS = 0.5 / np.sqrt(3.0)
CORNERS = np.array(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
)


@dataclass(frozen=True)
class Brick:
    """Free brick; three dofs per node, node by node."""

    nodes: Array  # (n, 3)
    cells: IntArray  # (c, 8)
    K: sp.csr_matrix
    M: sp.csr_matrix

    @property
    def dofs(self) -> list[tuple[int, int]]:
        """Node label (from 1) and direction (from 1) of every dof."""
        return [(node + 1, k + 1) for node in range(len(self.nodes)) for k in range(3)]


def brick(
    size: tuple[float, float, float],
    count: tuple[int, int, int],
    E: float = 70e9,
    nu: float = 0.3,
    density: float = 2700.0,
) -> Brick:
    """Brick [0, a] x [-b/2, b/2] x [-c/2, c/2] of equal elements, isotropic material."""
    axes = [np.linspace(0.0, 1.0, n + 1) for n in count]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    nodes = (grid - [0.0, 0.5, 0.5]) * size
    stride = np.array([(count[1] + 1) * (count[2] + 1), count[2] + 1, 1])
    first = np.array(list(product(*map(range, count)))) @ stride
    cells = first[:, None] + CORNERS @ stride
    h = np.array(size) / count
    Ke, Me = _element(h, E, nu, density)
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
    n = 3 * len(nodes)
    K, M = (
        sp.csr_matrix((np.tile(A.ravel(), len(cells)), (rows, columns)), (n, n)) for A in (Ke, Me)
    )
    return Brick(nodes, cells, K, M)


def _element(h: Array, E: float, nu: float, density: float) -> tuple[Array, Array]:
    lame, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    C = np.diag([2 * G, 2 * G, 2 * G, G, G, G])
    C[:3, :3] += lame
    Ke, Ms = np.zeros((24, 24)), np.zeros((8, 8))
    weight = float(np.prod(h)) / 8.0
    sign = 2 * CORNERS - 1
    for point in product((-GAUSS, GAUSS), repeat=3):
        part = 0.5 + sign * np.array(point)  # (8, 3)
        N = part.prod(axis=1)
        dN = np.stack(
            [sign[:, a] * part[:, (a + 1) % 3] * part[:, (a + 2) % 3] / h[a] for a in range(3)]
        )
        B = np.zeros((6, 24))
        for a in range(3):
            B[a, a::3] = dN[a]
        for row, (a, b) in zip((3, 4, 5), ((1, 2), (0, 2), (0, 1)), strict=True):
            B[row, a::3], B[row, b::3] = dN[b], dN[a]
        Ke += weight * B.T @ C @ B
        Ms += weight * density * np.outer(N, N)
    return Ke, np.kron(Ms, np.eye(3))
