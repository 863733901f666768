"""A second code for sections of cells of 3 to 9 nodes: dense matrices, other elements and formulas.

It reads nothing of plymotion. The stiffness follows from the central solutions of Giavotto et al.:
the six polynomial solutions of a long bar, found degree by degree by least squares.
"""

from typing import Any

import numpy as np

# natural coordinates of the nodes of a quadrilateral
XI = np.array([-1, 1, 1, -1, 0, 1, 0, -1, 0.0])
ETA = np.array([-1, -1, 1, 1, -1, 0, 1, 0, 0.0])


def functions(triangle: bool, present: list[int], u: float, v: float) -> Any:
    """Values and two slopes of the functions of the nodes present, by successive correction."""
    if triangle:
        L = np.array([1 - u - v, u, v])
        dL = np.array([[-1, -1], [1, 0], [0, 1.0]])
        N, dN = np.zeros(6), np.zeros((6, 2))
        N[:3], dN[:3] = L, dL
        for m, (a, b) in zip((3, 4, 5), ((0, 1), (1, 2), (2, 0)), strict=True):
            if m in present:
                N[m], dN[m] = 4 * L[a] * L[b], 4 * (dL[a] * L[b] + L[a] * dL[b])
                for corner in (a, b):
                    N[corner] -= 0.5 * N[m]
                    dN[corner] -= 0.5 * dN[m]
        return N[present], dN[present]
    N, dN = np.zeros(9), np.zeros((9, 2))
    bubble = (1 - u * u) * (1 - v * v)
    if 8 in present:
        N[8], dN[8] = bubble, [-2 * u * (1 - v * v), -2 * v * (1 - u * u)]
    for m in (4, 5, 6, 7):
        if m in present:
            if m in (4, 6):
                N[m] = 0.5 * (1 - u * u) * (1 + ETA[m] * v)
                dN[m] = [-u * (1 + ETA[m] * v), 0.5 * (1 - u * u) * ETA[m]]
            else:
                N[m] = 0.5 * (1 - v * v) * (1 + XI[m] * u)
                dN[m] = [0.5 * (1 - v * v) * XI[m], -v * (1 + XI[m] * u)]
            N[m] -= 0.5 * N[8]
            dN[m] -= 0.5 * dN[8]
    for c in range(4):
        N[c] = 0.25 * (1 + XI[c] * u) * (1 + ETA[c] * v) - 0.25 * N[8]
        dN[c] = [0.25 * XI[c] * (1 + ETA[c] * v), 0.25 * ETA[c] * (1 + XI[c] * u)]
        dN[c] -= 0.25 * dN[8]
        for m in ((4, 7), (4, 5), (5, 6), (6, 7))[c]:
            N[c] -= 0.5 * N[m]
            dN[c] -= 0.5 * dN[m]
    return N[present], dN[present]


def rule(triangle: bool, n: int) -> Any:
    """Product Gauss points (collapsed on a triangle) and weights."""
    g, w = np.polynomial.legendre.leggauss(n)
    if not triangle:
        return [
            (a, b, wa * wb) for a, wa in zip(g, w, strict=True) for b, wb in zip(g, w, strict=True)
        ]
    t = 0.5 * (g + 1)
    return [
        (a, b * (1 - a), 0.25 * wa * wb * (1 - a))
        for a, wa in zip(t, w, strict=True)
        for b, wb in zip(t, w, strict=True)
    ]


def orthotropic(c: dict[str, float]) -> Any:
    """Stiffness in the order 11, 22, 33, 23, 13, 12."""
    S = np.zeros((6, 6))
    E = [c["E1"], c["E2"], c["E3"]]
    nu = {(0, 1): c["nu12"], (0, 2): c["nu13"], (1, 2): c["nu23"]}
    for i in range(3):
        S[i, i] = 1 / E[i]
    for (i, j), value in nu.items():
        S[i, j] = S[j, i] = -value / E[i]
    S[3, 3], S[4, 4], S[5, 5] = 1 / c["G23"], 1 / c["G13"], 1 / c["G12"]
    return np.linalg.inv(S)


def turned(C: Any, theta1: float, theta3: float) -> Any:
    """Stiffness tensor turned by theta3 about axis 3, then by theta1 about axis 1 [deg]."""
    index = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    T = np.zeros((3, 3, 3, 3))
    for p, (i, j) in enumerate(index):
        for q, (k, m) in enumerate(index):
            for a, b in {(i, j), (j, i)}:
                for d, e in {(k, m), (m, k)}:
                    T[a, b, d, e] = C[p, q]
    c, s = np.cos(np.radians(theta3)), np.sin(np.radians(theta3))
    R3 = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    c, s = np.cos(np.radians(theta1)), np.sin(np.radians(theta1))
    R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ R3
    T = np.einsum("ia,jb,kc,ld,abcd->ijkl", R, R, R, R, T)
    return np.array([[T[i, j, k, m] for k, m in index] for i, j in index])


def stiffness(points: Any, cells: list[dict[str, Any]]) -> Any:
    """K (6, 6) of cells {"triangle", "present", "nodes", "C", "theta1", "theta3"}.

    `theta1` is a number, or one for each node of the cell. The rules are the usual ones: 3 x 3
    points in a quadrilateral with middle nodes, 2 x 2 in one without, exact in a straight triangle.
    """
    n = len(points)
    E, H, L = (np.zeros((3 * n, 3 * n)) for _ in range(3))
    for cell in cells:
        x = points[cell["nodes"]]
        for u, v, w in rule(
            cell["triangle"], 6 if cell["triangle"] else 2 + (len(cell["nodes"]) > 4)
        ):
            N, dN = functions(cell["triangle"], cell["present"], u, v)
            J = x.T @ dN
            slope = dN @ np.linalg.inv(J)
            area = w * abs(np.linalg.det(J))
            theta1 = cell["theta1"]
            theta1 = theta1 if np.ndim(theta1) == 0 else N @ theta1
            C = turned(cell["C"], theta1, cell["theta3"])
            B, A = np.zeros((6, 3 * len(N))), np.zeros((6, 3 * len(N)))
            B[1, 1::3] = B[3, 2::3] = B[5, 0::3] = slope[:, 0]
            B[3, 2::3] = slope[:, 0]
            B[5, 0::3] = slope[:, 0]
            B[4, 0::3] = slope[:, 1]
            B[3, 1::3] = slope[:, 1]
            B[2, 2::3] = slope[:, 1]
            A[0, 0::3] = A[5, 1::3] = A[4, 2::3] = N
            dofs = np.array([3 * k + a for k in cell["nodes"] for a in range(3)])
            at = np.ix_(dofs, dofs)
            E[at] += area * B.T @ C @ B
            H[at] += area * B.T @ C @ A
            L[at] += area * A.T @ C @ A
    return _central(E, H, L, points)


def _central(E: Any, H: Any, L: Any, points: Any) -> Any:
    """Warping W and strains S of u = Z q + W F with E W + H(W T + Z S) - (L Q + H'W) T = 0."""
    n = len(points)
    y, z = points.T
    Z = np.zeros((n, 3, 6))
    Z[:, 0, 0] = Z[:, 1, 1] = Z[:, 2, 2] = 1
    Z[:, 1, 3], Z[:, 2, 3], Z[:, 0, 4], Z[:, 0, 5] = -z, y, z, -y
    Z = Z.reshape(3 * n, 6)
    T = np.zeros((6, 6))
    T[4, 2], T[5, 1] = 1, -1
    # columns of T are unit vectors or zero: solve for the columns of F in order of their degree
    W, S = np.zeros((3 * n, 6)), np.zeros((6, 6))
    top = np.block([[E, H @ Z], [Z.T @ H.T, Z.T @ L @ Z]])
    pins = np.zeros((6, 3 * n + 6))
    pins[:, : 3 * n] = Z.T
    system = np.vstack([np.hstack([top, pins.T]), np.hstack([pins, np.zeros((6, 6))])])
    for column in (0, 3, 4, 5, 1, 2):
        WT, ST = W @ T[:, column], S @ T[:, column]
        # P of the column that this one changes into: [P T] = P_j
        PT = np.zeros(3 * n)
        for j in np.flatnonzero(T[:, column]):
            PT += T[j, column] * (H.T @ W[:, j] + L @ (Z @ S[:, j]))
        right = np.concatenate([PT - H @ WT, np.eye(6)[column] - Z.T @ L @ WT, np.zeros(6)])
        found = np.linalg.solve(system, right)
        W[:, column], S[:, column] = found[: 3 * n], found[3 * n : 3 * n + 6]
        del ST
    Q = W @ T + Z @ S
    flexibility = W.T @ E @ W + W.T @ H @ Q + Q.T @ H.T @ W + Q.T @ L @ Q
    return np.linalg.inv(0.5 * (flexibility + flexibility.T))


def relative(K: Any, other: Any) -> float:
    """The largest difference of two stiffness matrices, over the diagonal of the second one."""
    size = np.sqrt(np.outer(np.diag(other), np.diag(other)))
    return float((np.abs(K - other) / size).max())
