"""A second way to K of a section, by NumPy alone: `plymotion section --verify`.

Other functions, another map, another text than strains.py and what DOLFINx evaluates, and K from
the six polynomial solutions of a long bar (Giavotto et al. 1983) instead of (39) to (45). Of the
engine it takes the mesh, the numbering of the unknowns, the rule of integration, the material.
The solutions of a twisted or curved bar depend on each other and are those of one large system.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from ...solver.errors import coded
from ...solver.math.arrays import Array
from .. import fenicsx
from .space.section_cells import KINDS
from .space.space import SectionSpace

ROWS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def _functions(cell: str, nodes: Any, degree: int, place: Any) -> Any:
    """Values and two slopes at a place, (3, k), of the polynomials that are 1 at one node each."""

    def monomials(x: float, y: float) -> Any:
        powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1)]
        kept = [(i, j) for i, j in powers if cell == "quadrilateral" or i + j <= degree]
        values = [x**i * y**j for i, j in kept]
        by_x = [i * x ** max(i - 1, 0) * y**j for i, j in kept]
        by_y = [j * x**i * y ** max(j - 1, 0) for i, j in kept]
        return np.array([values, by_x, by_y])

    at_nodes = np.array([monomials(*node)[0] for node in nodes])
    return np.linalg.solve(at_nodes.T, monomials(*place).T).T


MOST_TWISTED = 12_000  # unknowns of a twisted section; six times as many are solved, in 20 s
LARGEST = 1e-6  # difference of K, scaled by sqrt(K_ii K_jj), that two right routes do not have


class Verified(NamedTuple):
    """Outcome of a verification: the difference, or why there is none; a finding, or none."""

    difference: float | None
    words: str
    warnings: list[dict[str, str]]


def verified(space: SectionSpace, C: Array, K: Array, *, k: Array | None, own: bool) -> Verified:
    """Compare K (6, 6) with that of a second method.

    Parameters
    ----------
    space : of the solution
    C : (c, 1 or q, 6, 6) stiffness of the cells or their points [Pa]
    k : (3,) initial twist and curvature [rad/m], None of a prismatic beam
    own : cells have the functions of their nodes, as in files of other codes
    """
    for there, what in (
        (
            k is not None and space.n_dof > MOST_TWISTED,
            f"a twisted or curved section of more than {MOST_TWISTED} unknowns",
        ),
        (own, "cells of another code"),
        (space.over is not None, "very thin walls, where it would lose all digits"),
        (space.unknowns is not None, "a refined mesh, which has hanging nodes"),
    ):
        if there:
            return Verified(None, f"not done for {what}", [])
    places, bent = np.column_stack([space.x2, space.x3]), np.zeros(3) if k is None else k
    E, H, L = matrices(space, C, bent)
    other = central_stiffness(E, H, L, places, bent)
    size = np.sqrt(np.diag(K))
    difference = float(np.abs((other - K) / np.outer(size, size)).max())
    warnings = []
    if not difference <= LARGEST:
        message = (
            f"K differs by {difference:.1e} of sqrt(K_ii K_jj) from K by a second method: "
            "please report the section"
        )
        warnings += coded("verification-differs", message)
    return Verified(difference, f"largest difference {difference:.1e}", warnings)


def matrices(space: SectionSpace, C: Array, k: Any = (0.0, 0.0, 0.0)) -> list[sp.csr_matrix]:
    """E, H, L of a space without hanging nodes, with G_k, G_l / g and g dA.

    Parameters
    ----------
    C : (c, 1 or q, 6, 6) stiffness of the cells or their points [Pa]
    k : (3,) twist and curvature [rad/m]
    """
    parts = [
        _of_kind(space, kind, rows, shapes, C[rows], k)
        for (kind, rows), shapes in zip(space.mesh.of_kinds, space.mesh.shapes, strict=True)
    ]
    return [sp.csr_matrix(sum(kinds)) for kinds in zip(*parts, strict=True)]


def _of_kind(space: SectionSpace, kind: int, rows: Any, shapes: Array, C: Array, k: Any) -> Any:
    """E, H, L of the cells of one kind, with the positions of their nodes (c, 6 or 9, 2)."""
    cell = KINDS[kind]
    nodes = fenicsx.reference_nodes(cell, space.degree)
    n, c = len(nodes), len(rows)
    dofs = space.dofs[rows, :n]
    matrices = np.zeros((3, c, 3 * n, 3 * n))
    points, weights = fenicsx.quadrature(cell, space.quadrature_degree)
    for q, (place, weight) in enumerate(zip(points, weights, strict=True)):
        map_ = _functions(cell, fenicsx.NODES[cell] / 2.0, 2, place)
        x, jacobian = (map_ @ shapes)[:, 0], (map_ @ shapes)[:, 1:]
        u, *slopes = _functions(cell, nodes, space.degree, place)
        by_x = np.linalg.solve(jacobian, np.broadcast_to(slopes, (c, 2, n)))
        x2, x3 = x.T[..., None]
        g = 1.0 - k[2] * x2 + k[1] * x3
        F = np.zeros((2, c, n, 3, 3, 3))  # of w and w': [cell, function, a, i, j] = d u_i / d x_j
        for a, e in enumerate(np.eye(3)):
            F[0, :, :, a, a, 1:] = by_x.swapaxes(1, 2)
            turned = k[0] * (x3 * by_x[:, 0] - x2 * by_x[:, 1])[..., None] * e
            F[0, :, :, a, :, 0] = (u[:, None] * np.cross(k, e) + turned) / g[..., None]
            F[1, :, :, a, a, 0] = u / g
        double = (F + F.swapaxes(-1, -2)).reshape(2, c, 3 * n, 3, 3)
        G, L = np.stack([double[..., i, j] / (2 if i == j else 1) for i, j in ROWS], axis=2)
        dA = (g[:, 0] * weight * np.abs(np.linalg.det(jacobian)))[:, None, None]
        for matrix, left, right in zip(matrices, (G, G, L), (G, L, L), strict=True):
            matrix += dA * left.swapaxes(1, 2) @ (C[:, min(q, C.shape[1] - 1)] @ right)
    unknowns = (3 * dofs[:, :, None] + np.arange(3)).reshape(c, -1)
    rows, columns = np.repeat(unknowns, 3 * n, axis=1).ravel(), np.tile(unknowns, 3 * n).ravel()
    size = (space.n_dof, space.n_dof)
    return [sp.csr_matrix((matrix.ravel(), (rows, columns)), shape=size) for matrix in matrices]


def central_stiffness(E: Any, H: Any, L: Any, places: Array, k: Any = (0.0, 0.0, 0.0)) -> Array:
    """K (6, 6) [N, N m, N m2] of a bar.

    The warping W and the strains S that unit resultants F cause in u = Z q + W F meet

        E W + H (W T + Z S) - (L Q + H'W) T = 0,    Q = W T + Z S,    F' = T F.

    Parameters
    ----------
    E, H, L : of `matrices`
    places : (n, 2) positions of the unknowns [m]
    k : (3,) twist and curvature [rad/m]
    """
    n, (y, z) = len(places), places.T
    rigid = np.zeros((n, 3, 6))
    rigid[:, 0, 0] = rigid[:, 1, 1] = rigid[:, 2, 2] = 1.0
    rigid[:, 1, 3], rigid[:, 2, 3], rigid[:, 0, 4], rigid[:, 0, 5] = -z, y, z, -y
    Z = rigid.reshape(3 * n, 6)
    T = np.zeros((6, 6))
    T[:3, :3] = T[3:, 3:] = np.cross(k, np.eye(3))
    T[4, 2], T[5, 1] = 1.0, -1.0
    free = np.setdiff1d(np.arange(3 * n), _held(places))
    W, S = (_together if any(k) else _in_turn)(E, H, L, Z, T, free)
    Q = W @ T + Z @ S
    flexibility = W.T @ (E @ W) + W.T @ (H @ Q) + Q.T @ (H.T @ W) + Q.T @ (L @ Q)
    return np.asarray(np.linalg.inv(0.5 * (flexibility + flexibility.T)))


def _together(E: Any, H: Any, L: Any, Z: Array, T: Array, free: Array) -> tuple[Array, Array]:
    """W and S from one system for all columns, one below the other."""
    HZ, LZ, n = H @ Z, L @ Z, E.shape[0]
    rows = (n * np.arange(6)[:, None] + free).ravel()

    def columns(plain: Any, once: Any, twice: Any) -> Any:
        """Of W -> plain W + once W T + twice W T T."""
        parts = (np.eye(6), plain), (T.T, once), (T.T @ T.T, twice)
        return sp.csr_matrix(sum(sp.kron(by, part) for by, part in parts))

    A = columns(E, H - H.T, -L)[rows][:, rows].tocsc()
    from_S = columns(HZ, -LZ, 0.0 * LZ)[rows].toarray()
    to_S = columns(HZ.T, LZ.T, 0.0 * LZ.T)[:, rows]
    options = {"SymmetricMode": True}
    factors = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    V = factors.solve(from_S)
    S = np.linalg.solve(np.kron(np.eye(6), Z.T @ LZ) - to_S @ V, np.eye(6).ravel())
    W = np.zeros(6 * n)
    W[rows] = -V @ S
    return W.reshape(6, n).T, S.reshape(6, 6).T


def _in_turn(E: Any, H: Any, L: Any, Z: Array, T: Array, free: Array) -> tuple[Array, Array]:
    """W and S of a prismatic bar, column by column."""
    HZ, LZ = H @ Z, L @ Z
    factors = fenicsx.cholesky(sp.csr_matrix(E[free][:, free]))

    def answer(loads: Array) -> Array:
        solution = np.zeros_like(loads)
        solution[free] = factors.solve(loads[free])
        return solution

    W_S = answer(HZ)
    schur = Z.T @ LZ - HZ.T @ W_S
    W, S = np.zeros(Z.shape), np.zeros((6, 6))
    for column in (0, 3, 4, 5, 1, 2):  # in the order of their degree
        WT, into = W @ T[:, column], T[:, column]
        load = H.T @ (W @ into) + L @ (Z @ (S @ into)) - H @ WT
        free_W = answer(load[:, None])[:, 0]
        strain = np.linalg.solve(schur, np.eye(6)[column] - LZ.T @ WT - HZ.T @ free_W)
        # a warping without mean motion, instead of one that is zero at the nodes held; a warping
        # that turns the section is a shear strain
        warping = free_W - W_S @ strain
        mean = np.linalg.solve(Z.T @ Z, Z.T @ warping)
        W[:, column], S[:, column] = warping - Z @ mean, strain + T.T @ mean
    return W, S


def _held(places: Array) -> list[int]:
    """Six displacements that hold a section: of three nodes far from each other."""
    a = int(np.argmin(places[:, 0]))
    b = int(np.argmax(np.linalg.norm(places - places[a], axis=1)))
    along = places[b] - places[a]
    off = np.abs((places - places[a]) @ np.array([-along[1], along[0]]))
    c = int(np.argmax(off))
    across = int(abs(along[0]) > abs(along[1]))  # the component that turning about a moves at b
    return [3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + 1 + across, 3 * c]
