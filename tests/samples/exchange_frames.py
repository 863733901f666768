"""A frame of Euler-Bernoulli beams with consistent mass: six dofs per node, coupled masses."""

import numpy as np

from plymotion.solver.math.arrays import Array

EA, GJ, EI, LINE, TWIST = 2e6, 40.0, 60.0, 0.8, 2e-5


def frame() -> tuple[Array, list[tuple[int, int]], Array, Array]:
    """Nodes of an L in space, dofs, and dense K and M."""
    leg = [(0.1 * i, 0.0, 0.0) for i in range(6)]
    arm = [(0.5, 0.1 * i, 0.05 * i) for i in range(1, 5)]
    nodes = np.array(leg + arm)
    n = len(nodes)
    K, M = np.zeros((6 * n, 6 * n)), np.zeros((6 * n, 6 * n))
    for i in range(n - 1):
        along = nodes[i + 1] - nodes[i]
        h = float(np.linalg.norm(along))
        e1 = along / h
        e2 = np.cross([0.0, 0.0, 1.0], e1)
        e2 /= np.linalg.norm(e2)
        A = np.kron(np.eye(4), np.array([e1, e2, np.cross(e1, e2)]))
        part = slice(6 * i, 6 * i + 12)
        for whole, own in zip((K, M), _element(h), strict=True):
            whole[part, part] += A.T @ own @ A
    dofs = [(node + 1, k + 1) for node in range(n) for k in range(6)]
    return nodes, dofs, K, M


def _element(h: float) -> tuple[Array, Array]:
    k, m = np.zeros((12, 12)), np.zeros((12, 12))
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    sums = np.array([[2.0, 1.0], [1.0, 2.0]])
    for rows, stiff, mass in (([0, 6], EA, LINE), ([3, 9], GJ, TWIST)):
        at = np.ix_(rows, rows)
        k[at], m[at] = stiff / h * pair, mass * h / 6.0 * sums
    bending = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    )
    inertia = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h * h, 13 * h, -3 * h * h],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
        ]
    )
    for rows, sign in (([1, 5, 7, 11], 1.0), ([2, 4, 8, 10], -1.0)):
        turn = np.diag([1.0, sign, 1.0, sign])
        at = np.ix_(rows, rows)
        k[at] = turn @ bending @ turn * EI / h**3
        m[at] = turn @ inertia @ turn * LINE * h / 420.0
    return k, m
