"""A helical bar of 27-node bricks: a second route to the compliance of its sections."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from plymotion.preprocess import fenicsx
from plymotion.solver.math.rotations import skew

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(3)


def _line(x: Any) -> tuple[Any, Any]:
    """Quadratic functions of nodes -1, 0, 1 at x (q,), and slopes, (q, 3)."""
    values = np.stack([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], axis=-1)
    return values, np.stack([x - 0.5, -2.0 * x, x + 0.5], axis=-1)


def compliance(
    sides: tuple[float, float], k: Any, C: Any, length: float, n: tuple[int, int, int]
) -> Any:
    """S (6, 6): energy of the middle fifth of a bar under resultants on one end.

    Parameters
    ----------
    sides : width along x2 and height along x3
    k : (3,) initial twist and curvature
    C : (6, 6) stiffness in section axes, order 11, 22, 33, 23, 13, 12
    n : bricks along x1, x2, x3; n[0] is a multiple of 5
    """
    k = np.asarray(k, dtype=float)
    counts = [2 * m + 1 for m in n]
    s = np.linspace(0.0, length, counts[0])
    y = np.linspace(-0.5 * sides[0], 0.5 * sides[0], counts[1])
    z = np.linspace(-0.5 * sides[1], 0.5 * sides[1], counts[2])
    # axes of the section and positions of the reference line, by one exponential for each step
    spin = np.zeros((4, 4))
    spin[:3, :3], spin[:3, 3] = skew(k), [1.0, 0.0, 0.0]
    frames = np.array([expm(x * spin) for x in s])
    local = np.stack([np.zeros((len(y), len(z))), *np.meshgrid(y, z, indexing="ij")], axis=-1)
    x = frames[:, None, None, :3, 3] + np.einsum("sab,yzb->syza", frames[:, :3, :3], local)
    number = np.arange(np.prod(counts)).reshape(counts)
    cells = np.array(
        [
            number[2 * i : 2 * i + 3, 2 * j : 2 * j + 3, 2 * m : 2 * m + 3].ravel()
            for i in range(n[0])
            for j in range(n[1])
            for m in range(n[2])
        ]
    )
    nodes = x.reshape(-1, 3)
    grid = np.stack(np.meshgrid(POINTS, POINTS, POINTS, indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.einsum("i,j,k->ijk", WEIGHTS, WEIGHTS, WEIGHTS).ravel()
    (a, da), (b, db), (c, dc) = (_line(grid[:, i]) for i in range(3))
    slopes = np.stack(
        [
            np.einsum("qi,qj,qk->qijk", *f).reshape(27, 27)
            for f in ((da, b, c), (a, db, c), (a, b, dc))
        ],
        axis=-1,
    )
    position = np.einsum("qi,qj,qk->qijk", a, b, c).reshape(27, 27)
    jacobian = np.einsum("eia,qig->eqag", nodes[cells], slopes)
    volume = weights * np.linalg.det(jacobian)
    gradients = np.einsum("qig,eqga->eqia", slopes, np.linalg.inv(jacobian))
    arc = np.einsum("qi,ei->eq", position, np.repeat(s, counts[1] * counts[2])[cells])
    order = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    matrices = np.empty((len(cells), 81, 81))
    for e in range(len(cells)):
        # section axes as columns
        A = Rotation.from_rotvec(arc[e][:, None] * k).as_matrix()
        along = np.einsum("qia,qab->qib", gradients[e], A)  # slopes along them
        B = np.zeros((27, 6, 27, 3))
        for row, (i, j) in enumerate(order):
            B[:, row] += along[:, :, j, None] * A[:, None, :, i]
            if i != j:
                B[:, row] += along[:, :, i, None] * A[:, None, :, j]
        B = B.reshape(27, 6, 81)
        matrices[e] = np.einsum("q,qri,rs,qsj->ij", volume[e], B, C, B, optimize=True)
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 81)
    rows, columns = np.repeat(dofs, 81, axis=1).ravel(), np.tile(dofs, (1, 81)).ravel()
    K = sp.csr_matrix((matrices.ravel(), (rows, columns)), shape=(3 * len(nodes),) * 2)
    load = _end_loads(number[-1], y, z, local, frames[-1, :3, :3], sides)
    free = np.setdiff1d(np.arange(K.shape[0]), (3 * number[0].ravel()[:, None] + np.arange(3)))
    u = np.zeros((K.shape[0], 6))
    full = np.zeros((K.shape[0], 6))
    full[load[0]] = load[1]
    u[free] = fenicsx.cholesky(K[free][:, free]).solve(full[free])
    # energy of the middle fifth, and the same integral of F' S F
    per = n[1] * n[2]
    middle = np.arange(2 * n[0] // 5 * per, 3 * n[0] // 5 * per)
    U = np.einsum(
        "eim,eij,ejn->mn", u[dofs[middle]], matrices[middle], u[dofs[middle]], optimize=True
    )
    T = np.zeros((6, 6))
    T[:3, :3] = T[3:, 3:] = -skew(k)
    T[3:, :3] = -skew([1.0, 0.0, 0.0])
    total = np.zeros((36, 36))
    t, w = np.polynomial.legendre.leggauss(12)
    for place, weight in zip(length * (0.5 + 0.1 * t), 0.1 * length * w, strict=True):
        F = expm(T * (place - length))
        total += weight * np.kron(F.T, F.T)
    S = np.linalg.solve(total, U.ravel()).reshape(6, 6)
    return 0.5 * (S + S.T)


def _end_loads(face: Any, y: Any, z: Any, local: Any, A: Any, sides: Any) -> tuple[Any, Any]:
    """Rows and forces (m, 6) of tractions linear over the end, one column for each resultant."""
    width = []
    for line in (y, z):
        w = np.zeros(len(line))
        for i in range(0, len(line) - 1, 2):
            w[i : i + 3] += (line[i + 2] - line[i]) / 6.0 * np.array([1.0, 4.0, 1.0])
        width.append(w)
    area = np.outer(*width)
    b, t = sides
    forces = np.zeros((*local.shape[:2], 3, 6))
    for i in range(3):
        forces[:, :, i, i] = area / (b * t)
    I2, I3 = b * t**3 / 12.0, t * b**3 / 12.0
    forces[:, :, 1, 3] = -area * local[:, :, 2] / (I2 + I3)
    forces[:, :, 2, 3] = area * local[:, :, 1] / (I2 + I3)
    forces[:, :, 0, 4] = area * local[:, :, 2] / I2
    forces[:, :, 0, 5] = -area * local[:, :, 1] / I3
    forces = np.einsum("ab,yzbm->yzam", A, forces)
    return (3 * face.ravel()[:, None] + np.arange(3)).ravel(), forces.reshape(-1, 6)
