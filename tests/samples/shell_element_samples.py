"""Laminates, patches and an assembly for tests of the shell elements alone."""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from plymotion.preprocess.shell.elements.pairs import (
    Choice,
    kernel_of,
    mass_kernel,
    stiffness_kernel,
)
from plymotion.preprocess.shell.elements.plates import shear_ratio
from plymotion.preprocess.shell.elements.single_cells import cell_matrices, cell_table, write
from plymotion.preprocess.shell.shell_cells import (
    CellGeometry,
    width_ratios,
)
from plymotion.preprocess.shell.shell_cells import cell_geometry as quadrilaterals
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles
from plymotion.solver.package.shell import elements

QUADS = tuple(elements.QUADS)
PLATES, MEMBRANES = tuple(elements.PLATES), tuple(elements.MEMBRANES)


class Plain(NamedTuple):
    """A laminate by its stiffness."""

    A: np.ndarray
    B: np.ndarray
    D: np.ndarray
    Ds: np.ndarray


def isotropic(thickness: float, nu: float = 0.3, E: float = 1.0) -> Plain:
    Q = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    shear = 5 / 6 * E / (2 * (1 + nu)) * thickness * np.eye(2)
    return Plain(Q * thickness, 0 * Q, Q * thickness**3 / 12, shear)


def coupled(thickness: float) -> Plain:
    """Two layers of positive definite stiffness without any symmetry: all couplings."""
    rng = np.random.default_rng(5)
    lower, upper = (X @ X.T + 2 * np.eye(3) for X in rng.normal(size=(2, 3, 3)))
    X = rng.normal(size=(2, 2))
    h = 0.5 * thickness
    return Plain(
        (lower + upper) * h,
        (upper - lower) * h**2 / 2,
        (lower + upper) * h**3 / 3,
        (X @ X.T + np.eye(2)) * thickness,
    )


def element_stiffness(t: CellGeometry, laminate: Plain, choice: Choice) -> np.ndarray:
    """Stiffness of single cells in G, (c, 18, 18) or (c, 24, 24)."""
    kernel = stiffness_kernel(t.xy_E.shape[1], choice)
    return cell_matrices(t, kernel, cell_table(t, laminate, choice))


def part_stiffness(
    t: CellGeometry, laminate: Plain, kind: str, name: str, beta0: float | str = 0.5
) -> np.ndarray:
    """Stiffness of a membrane or plate alone in E, (c, 18, 18)."""
    table = cell_table(t, laminate, Choice(beta0=beta0))
    K = cell_matrices(t, kernel_of(3, (kind, name)), table)
    blocks = K.reshape(-1, 6, 3, 6, 3)
    return np.einsum("cki,cakbl,clj->caibj", t.A_GE, blocks, t.A_GE).reshape(-1, 18, 18)


def element_mass(t: CellGeometry, mass: np.ndarray, form: str = "consistent") -> np.ndarray:
    """Mass of single cells in G, (c, 18, 18) or (c, 24, 24)."""
    kernel = mass_kernel(t.xy_E.shape[1], form)
    table = cell_table(t, isotropic(1.0), Choice())
    write(table, mass=mass)
    return cell_matrices(t, kernel, table)


def ratios(t: CellGeometry, laminate: Plain) -> np.ndarray:
    """`shear_ratio` of the sides, (c, 3)."""
    return shear_ratio(laminate.D, laminate.Ds, np.moveaxis(t.tangent, 2, 0), t.length)


def turn(seed: int) -> np.ndarray:
    """A rotation in space."""
    Q, R = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.linalg.det(Q)


SOMEHOW = turn(2)


def patch() -> tuple[np.ndarray, np.ndarray]:
    """Unit square with four nodes inside it, irregular: points (8, 2), cells (10, 3)."""
    points = np.array(
        [[0, 0], [1, 0], [1, 1], [0, 1], [0.2, 0.2], [0.75, 0.25], [0.65, 0.7], [0.3, 0.6]]
    )
    quads = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
    cells = [c for a, b, c_, d in quads for c in ((a, b, c_), (a, c_, d))]
    return points, np.array(cells)


def quad_patch() -> tuple[np.ndarray, np.ndarray]:
    """The patch as quadrilaterals: points (8, 2), cells (5, 4)."""
    points, _ = patch()
    return points, np.array([(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)])


def grid(n: int, warp: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Unit square of n x n cells with alternating diagonals, n even."""
    line = np.linspace(0, 1, n + 1)
    points = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    if warp:
        inside = ((points > 1e-9) & (points < 1 - 1e-9)).all(axis=1)
        shift = np.random.default_rng(1).uniform(-warp / n, warp / n, points.shape)
        points = points + shift * inside[:, None]
    cells = []
    for i in range(n):
        for j in range(n):
            a, b = i * (n + 1) + j, (i + 1) * (n + 1) + j
            c, d = b + 1, a + 1
            cells += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    return points, np.array(cells)


def in_space(points: np.ndarray, A_GE: np.ndarray) -> np.ndarray:
    """Points of a plane (n, 2) placed in space (n, 3)."""
    return points @ A_GE[:, :2].T + np.array([0.3, -0.2, 0.5])


def assembled(K: np.ndarray, cells: np.ndarray, n: int) -> sp.csr_matrix:
    dofs = (6 * cells[:, :, None] + np.arange(6)).reshape(len(cells), -1)
    size = dofs.shape[1]
    rows, columns = np.repeat(dofs, size, axis=1).ravel(), np.tile(dofs, size).ravel()
    return sp.csr_matrix((K.ravel(), (rows, columns)), shape=(6 * n, 6 * n))


def nodal(u_G: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Nodal values (n, 6) gathered as (c, 18|24, 1)."""
    return u_G[cells].reshape(len(cells), -1, 1)


def solved(K: sp.csr_matrix, given: np.ndarray, known: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Displacements (6 n,) with those of `known` given."""
    u = np.where(known, given, 0.0)
    free = ~known
    K_free, rest = K[free][:, free], (load - K @ u)[free]
    scale = 1.0 / np.sqrt(K_free.diagonal())  # stretching and bending differ by powers of ten
    scaled = sp.diags(scale) @ K_free @ sp.diags(scale)
    u[free] = scale * spsolve(scaled.tocsc(), scale * rest, permc_spec="MMD_AT_PLUS_A")
    return u


def state(xy: np.ndarray, e: np.ndarray, k: np.ndarray, A_GE: np.ndarray) -> np.ndarray:
    """Nodal values (n, 6) in G of constant strain e and curvature k, without shear strain."""
    x, y = xy.T
    u = e[0] * x + 0.7 * e[2] * y
    v = e[1] * y + 0.3 * e[2] * x
    bx, by = k[0] * x + 0.5 * k[2] * y, k[1] * y + 0.5 * k[2] * x
    w = -0.5 * (k[0] * x**2 + k[1] * y**2 + k[2] * x * y)
    tz = np.full_like(x, 0.5 * (0.3 - 0.7) * e[2])
    moved, turned = np.stack([u, v, w], axis=1), np.stack([-by, bx, tz], axis=1)
    return np.hstack([moved @ A_GE.T, turned @ A_GE.T])


def patch_error(
    laminate: Plain, choice: Choice, e: np.ndarray, k: np.ndarray, A_GE: np.ndarray = SOMEHOW
) -> float:
    """Largest error of the nodes inside a patch in a constant state given at its corners.

    Relative to the largest displacement and rotation, each to its own.
    """
    xy, cells = patch()
    points = in_space(xy, A_GE)
    t = triangles(points, cells, A_GE[:, 0])
    K = assembled(element_stiffness(t, laminate, choice), cells, len(xy))
    return _patch_error(K, xy, e, k, A_GE)


def quad_patch_error(
    laminate: Plain,
    choice: Choice,
    e: np.ndarray,
    k: np.ndarray,
    A_GE: np.ndarray = SOMEHOW,
    cut: int = 0,
    backwards: bool = False,
    beside: Choice | None = None,
) -> float:
    """`patch_error` of quadrilaterals, the last `cut` of them cut into triangles (`beside`)."""
    xy, cells = quad_patch()
    points = in_space(xy, A_GE)
    whole, parts = cells[: len(cells) - cut], cells[len(cells) - cut :]
    halves = parts[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    mixed = np.concatenate([whole, np.pad(halves, ((0, 0), (0, 1)), constant_values=-1)])
    ratios = width_ratios(points, mixed)[: len(whole)]
    if backwards:
        whole, ratios = whole[:, ::-1], ratios[:, [2, 1, 0, 3]]
    q = quadrilaterals(points, whole, A_GE[:, 0], backwards, ratios)
    K = assembled(element_stiffness(q, laminate, choice), whole, len(xy))
    if cut:
        t = triangles(points, halves, A_GE[:, 0])
        K = K + assembled(element_stiffness(t, laminate, beside or choice), halves, len(xy))
    return _patch_error(K, xy, e, k, A_GE)


def _patch_error(
    K: sp.csr_matrix, xy: np.ndarray, e: np.ndarray, k: np.ndarray, A_GE: np.ndarray
) -> float:
    exact = state(xy, e, k, A_GE)
    known = np.zeros((len(xy), 6), dtype=bool)
    known[:4] = True
    u = solved(K, exact.ravel(), known.ravel(), np.zeros(exact.size)).reshape(-1, 6)
    error, size = np.abs(u - exact), np.abs(exact)
    kinds = (slice(0, 3), slice(3, 6))
    return float(max(error[:, kind].max() / size[:, kind].max() for kind in kinds))


def one_triangle(seed: int = 3) -> tuple[CellGeometry, np.ndarray, np.ndarray]:
    """A triangle somewhere in space, its corners and its reference direction."""
    points = np.random.default_rng(seed).normal(size=(3, 3))
    direction = np.array([0.4, 1.0, -0.3])
    return triangles(points, np.array([[0, 1, 2]]), direction), points, direction


def one_quadrilateral(warp: float = 0.0, seed: int = 3) -> tuple[CellGeometry, np.ndarray]:
    """An irregular quadrilateral somewhere in space, warped or flat, and its corners."""
    flat = np.array([[0, 0, 0], [1.1, 0.1, 0], [1.2, 0.9, warp], [-0.1, 1.2, 0]])
    points = flat @ turn(seed).T
    return quadrilaterals(points, np.array([[0, 1, 2, 3]]), np.array([0.4, 1.0, -0.3])), points


def rigid_motions(points: np.ndarray) -> np.ndarray:
    """Six rigid motions of nodes (n, 3), (6 n, 6)."""
    moves = np.zeros((len(points), 6, 6))
    moves[:, :3, :3] = moves[:, 3:, 3:] = np.eye(3)
    for i in range(3):
        moves[:, :3, 3 + i] = np.cross(np.eye(3)[i], points)
    return moves.reshape(-1, 6)
