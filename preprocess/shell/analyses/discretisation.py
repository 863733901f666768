"""Estimated discretisation errors of load cases, load factors and frequencies from a finer mesh.

It has cells of half the size. The elements are of second order: of the difference of two meshes, a
third is left in the finer one.
On the finer mesh the known shapes are improved by a block Krylov space of few vectors, which costs
one factorisation and a few solutions; the prestress is computed there as well.

A curved surface is known from its nodes only. A quadratic function fitted to the nodes around a
cell gives the distance of its side's middle from the chord. Neighbours whose normals differ by more
than `FOLD` belong to another surface; the curve in which two surfaces meet lies on both.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import NONE, corner_counts
from ... import fenicsx
from ..model.freedom import Freedom
from ..model.shell_problem import ShellProblem
from ..shell_cells import DOFS, ShellError, ShellMesh
from ..shell_mesh import split
from .buckling import LoadFactors, Stressed
from .cases import solve_cases

FOLD = 0.75  # least cosine between normals of one smooth surface: 41 deg
FLAT = 1e-8  # of the largest eigenvalue: a direction in which the nodes around a cell do not extend
ONE_SURFACE = 0.1  # the same for the normals of the cells at a side: below, they are of one surface


class Refined(NamedTuple):
    """A finer mesh, and the values at its nodes of functions that are linear along sides."""

    mesh: ShellMesh
    from_coarse: sp.csr_matrix  # (n_fine, n)


@lru_cache(maxsize=2)
def refined(mesh: ShellMesh) -> Refined:
    """The mesh with twice as many cells along every side; the old nodes come first."""
    n, cells = mesh.n_node, mesh.cells
    straight, heights = split(mesh), _heights(mesh)
    # four sides that meet at a centre: half the sum of their middles less a quarter of the corners
    four = np.flatnonzero(corner_counts(cells) == 4)
    of_cell = np.zeros((len(cells), 3))
    np.add.at(of_cell, mesh.edges.owner, 0.5 * heights[mesh.edges.number])
    above = np.concatenate([np.zeros((n, 3)), heights, of_cell[four]])
    fine = replace(straight, points_G=straight.points_G + above)
    return Refined(fine, _interpolation(n, mesh.edges.nodes, cells[four]))


def _interpolation(n: int, pairs: IntArray, four: IntArray) -> sp.csr_matrix:
    """Means of the ends of sides and of the corners of quadrilaterals, (n_fine, n)."""
    blocks = [sp.identity(n, format="csr")]
    for nodes in (pairs, four):
        m, k = nodes.shape
        entries = (np.full(m * k, 1.0 / k), (np.repeat(np.arange(m), k), nodes.ravel()))
        blocks.append(sp.csr_matrix(entries, shape=(m, n)))
    return sp.csr_matrix(sp.vstack(blocks))


def _heights(mesh: ShellMesh) -> Array:
    """From the chord to the surface in the middle of each edge, (e, 3) [m]."""
    edges, owner = mesh.edges, mesh.edges.owner
    axes, curvature = _curvatures(mesh)
    along = np.einsum("sij,sj->si", axes[owner], np.diff(mesh.points_G[edges.ends], axis=1)[:, 0])[
        :, :2
    ]
    height = -0.125 * np.einsum("si,sij,sj->s", along, curvature[owner], along)
    normal = axes[owner, 2]
    A, b = edges.sums(normal[:, :, None] * normal[:, None]), edges.sums(height[:, None] * normal)
    inverse = np.linalg.pinv(A, rcond=ONE_SURFACE, hermitian=True)
    return np.asarray(np.einsum("sij,sj->si", inverse, b))


def _curvatures(mesh: ShellMesh) -> tuple[Array, Array]:
    """Axes (c, 3, 3) of each cell as rows; second derivatives (c, 2, 2) of its surface [1/m]."""
    areas = mesh.area_vectors_G
    normal = areas / np.linalg.norm(areas, axis=1, keepdims=True)
    e1 = mesh.points_G[mesh.cells[:, 1]] - mesh.points_G[mesh.cells[:, 0]]
    e1 -= normal * (e1 * normal).sum(axis=1, keepdims=True)
    e1 /= np.linalg.norm(e1, axis=1, keepdims=True)
    axes = np.stack([e1, np.cross(normal, e1), normal], axis=1)
    cell, node = _around(mesh, normal)
    size = np.sqrt(np.linalg.norm(areas, axis=1))
    away = (mesh.points_G[node] - mesh.centres_G[cell]) / size[cell, None]
    x, y, z = np.einsum("kij,kj->ik", axes[cell], away)
    terms = np.stack([np.ones_like(x), x, y, 0.5 * x * x, x * y, 0.5 * y * y], axis=1)
    A, b = np.zeros((len(areas), 6, 6)), np.zeros((len(areas), 6))
    np.add.at(A, cell, terms[:, :, None] * terms[:, None, :])
    np.add.at(b, cell, terms * z[:, None])
    fitted = np.einsum("cij,cj->ci", np.linalg.pinv(A, rcond=FLAT, hermitian=True), b)
    second = fitted[:, [3, 4, 4, 5]].reshape(-1, 2, 2)
    return axes, second / size[:, None, None]


def _around(mesh: ShellMesh, normal: Array) -> tuple[IntArray, IntArray]:
    """Pairs of a cell and a node of it or of a neighbour of the same surface, each once."""
    c = len(mesh.cells)
    row, column = np.nonzero(mesh.cells != NONE)
    corner = mesh.cells[row, column]
    at = sp.csr_matrix((np.ones(len(row)), (row, corner)), shape=(c, mesh.n_node))
    near = sp.coo_matrix(at @ at.T)
    smooth = np.abs((normal[near.row] * normal[near.col]).sum(axis=1)) > FOLD
    entries = (np.ones(smooth.sum()), (near.row[smooth], near.col[smooth]))
    nearest = sp.coo_matrix(sp.csr_matrix(entries, shape=(c, c)) @ at)
    return nearest.row, nearest.col


STEPS = 3  # of the Krylov space
# Error of the coarser mesh over the difference, second and first order; part of a difference that
# halving the cells leaves: of first order, at most.
REST, FIRST, LEFT, MOST_LEFT = 4.0 / 3.0, 2.0, 0.5, 0.6
CHEAP = 4000  # unknowns up to which errors are estimated by default: half a second
MOST = 300_000  # unknowns of the finer mesh, above which there is no estimate
DEPENDENT = 1e-13  # of the largest eigenvalue of a Gram matrix of unit vectors


class FinerMesh:
    """The same shell on a mesh of half the cell size, made when it is needed.

    Parameters
    ----------
    coarse : the shell on its own mesh
    begin : called with one line when it is made
    """

    def __init__(self, coarse: ShellProblem, begin: Callable[[str], None]) -> None:
        self._coarse, self.begin = coarse, begin

    @cached_property
    def _refined(self) -> Refined:
        return refined(self._coarse.mesh)

    @property
    def unknowns(self) -> int:
        """Number of degrees of freedom of its nodes."""
        return DOFS * self._refined.mesh.n_node

    @property
    def cheap(self) -> bool:
        """Errors are estimated without being asked for."""
        return DOFS * self._coarse.mesh.n_node <= CHEAP

    @cached_property
    def problem(self) -> ShellProblem:
        """Its model."""
        coarse = self._coarse
        self.begin(f"errors, from a mesh of half the cell size: {self.unknowns} unknowns")
        return ShellProblem(coarse.spec, coarse.where, mesh=self._refined.mesh)

    @cached_property
    def stressed(self) -> Stressed:
        """The shell with its load cases."""
        problem, freedom = self.problem, self.problem.freedom
        cases = problem.spec.get("loads", {})
        forces, given = problem.loads.columns(cases, problem.where)
        names = tuple(cases)
        if not names:
            return Stressed(problem, names, forces)
        solved = solve_cases(problem.K, freedom, forces, names, problem.team, given)
        return Stressed(problem, names, solved.displacements)

    def energies(self) -> Array:
        """Strain energies of its load cases, (l,) [J]. Raises ShellError."""
        u = self.stressed.u
        return np.asarray(0.5 * np.einsum("nl,nl->l", u, self.problem.K @ u))

    def shapes(self, coarse: Array) -> Array:
        """Displacements (n_dof, m) of nodes and reference points from those of the coarse mesh."""
        nodes = self._refined.from_coarse
        n = nodes.shape[1]
        table = coarse.reshape(-1, DOFS, coarse.shape[1])
        fine = (nodes @ table[:n].reshape(n, -1)).reshape(-1, DOFS, coarse.shape[1])
        return np.concatenate([fine, table[n:]]).reshape(-1, coarse.shape[1])


def energy_errors(finer: FinerMesh, energy: Array, *, slow: bool = False) -> Array | None:
    """Relative errors (l,) of the strain energies of load cases, above 0 if one is too high.

    None if the finer mesh is too large, or not possible.

    Parameters
    ----------
    finer : the shell on a mesh of half the cell size
    energy : (l,) strain energies on its own mesh [J]
    slow : the error may fall with a lower power of the cell size than the second, which a third
        mesh finds where that is cheap
    """
    if finer.unknowns > MOST:
        return None
    third = slow and finer.unknowns <= 4 * CHEAP
    try:
        fine = finer.energies()
        third_energies = FinerMesh(finer.problem, finer.begin).energies() if third else None
    except ShellError:
        return None
    loaded = energy > 0.0
    difference = (FIRST if slow else REST) * (energy - fine)
    if third_energies is not None:
        # Ratio of successive differences under halving: a quarter for second order, half for first;
        # negative where cells that are too soft stand beside cells that are too stiff.
        one, two = energy - fine, fine - third_energies
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.nan_to_num(two / one, nan=0.25)
        left = np.where(left < 0.0, LEFT, np.clip(left, 0.25, MOST_LEFT))
        difference = one + two / (1.0 - left)
    return np.divide(difference, energy - difference, where=loaded, out=np.zeros(len(energy)))


def at_points(problem: ShellProblem, key: str) -> set[str]:
    """Load cases with loads of a key at points, or at links of points."""
    links = [link.name for link in problem.links if link.group.kind == "point"]
    points = {*problem.mesh.marks, *links}
    return {
        name
        for name, case in problem.spec.get("loads", {}).items()
        if any(e.get(key) is not None and e.get("at") in points for e in case.values())
    }


def load_factor_errors(
    finer: FinerMesh, table: Mapping[str, Any], by_case: Mapping[str, LoadFactors]
) -> dict[str, Array] | None:
    """Relative errors (m,) of load factors, above 0 if a factor is too high, by load case.

    None if the finer mesh is too large, or has no stiffness left under the constant load.

    Parameters
    ----------
    table : of `buckling`, see buckling.py
    by_case : load factors and shapes of each case on the coarse mesh
    """
    if finer.unknowns > MOST:
        return None
    in_plane, freedom = table.get("in_plane", True), finer.problem.modes_freedom
    where, errors = f"{finer.problem.where}.buckling", {}
    try:
        equations = _Equations(finer, table.get("constant"), f"{where}.constant", in_plane)
    except (ShellError, fenicsx.FactorisationError):
        return None
    for name, factors in by_case.items():
        errors[name] = np.zeros(0)
        if len(factors.values) == 0:  # the case does not buckle the shell
            continue
        Kg = finer.stressed.geometric(name, f"{where}.cases", in_plane)
        mu = equations.largest(freedom.reduced(-Kg), factors.shapes)
        errors[name] = _error(factors.values, 1.0 / mu)
    equations.factor.close()
    return errors


def frequency_errors(
    finer: FinerMesh,
    case: str | None,
    values: Array,
    shapes: Array,
    n_zero: int = 0,
    free: bool = False,
) -> Array | None:
    """Relative errors (m,) of frequencies of a shell under a load case.

    None if the finer mesh is too large, has buckled, or is not possible.

    Parameters
    ----------
    values, shapes : (m,) [rad/s], (n_dof, m)
    n_zero : number of modes without strain energy, which come first; their error is 0
    free : without the supports
    """
    if finer.unknowns > MOST or len(values) == n_zero:
        return None
    shift = float(values[n_zero] ** 2) if n_zero else 0.0  # K alone is singular
    try:
        problem = finer.problem
        freedom = problem.modes_freedom
        if free:
            freedom = Freedom(problem.mesh, problem.links, flat=problem.flat)
        where = f"{problem.where}.frequencies.prestress"
        equations = _Equations(finer, case, where, freedom=freedom, shift=shift)
    except (ShellError, fenicsx.FactorisationError):
        return None
    mu = equations.largest(freedom.reduced(problem.M), shapes)
    equations.factor.close()
    errors = np.zeros(len(values))
    fine = np.sqrt((1.0 / mu - shift)[n_zero:].clip(min=0.0))
    errors[n_zero:] = _error(values[n_zero:], fine)
    return errors


class _Equations:
    """G x = mu K x on the finer mesh, K the stiffness under a load case plus shift times M.

    Raises ShellError, FactorisationError : K is not definite.
    """

    def __init__(
        self,
        finer: FinerMesh,
        case: str | None,
        where: str,
        in_plane: bool = True,
        freedom: Freedom | None = None,
        shift: float = 0.0,
    ) -> None:
        problem = finer.problem
        self._finer, self._freedom = finer, freedom or problem.modes_freedom
        # without a prestress the load cases need no solution on the finer mesh
        K = problem.K if case is None else finer.stressed.stiffness(case, where, in_plane)
        K = self._freedom.reduced(K)
        if shift:
            K = K + shift * self._freedom.reduced(problem.M)
        self.factor = fenicsx.cholesky(K, finer.problem.team)

    def largest(self, G: sp.csr_matrix, coarse: Array) -> Array:
        """The largest mu, (m,) descending, in the Krylov space of m coarse shapes (n_dof, m)."""
        X = self._finer.shapes(coarse)[self._freedom.free]
        count = X.shape[1]
        if not count:
            return np.zeros(0)
        blocks, loads = [], []
        for _ in range(STEPS):
            load = np.asarray(G @ X)
            X = self.factor.solve(load)
            # x'Kx by the load K x: K times a nearly rigid motion of a thin shell is rounding
            size = np.sqrt(np.einsum("nm,nm->m", X, load))
            X = X / size
            blocks.append(X)
            loads.append(load / size)
        S, L = np.concatenate(blocks, axis=1), np.concatenate(loads, axis=1)
        products, axes = scipy.linalg.eigh(_symmetric(S.T @ L))
        kept = products > DEPENDENT * products[-1]
        T = axes[:, kept] / np.sqrt(products[kept])
        S, L = S @ T, L @ T
        mu = scipy.linalg.eigvalsh(_symmetric(S.T @ (G @ S)), _symmetric(S.T @ L))
        return np.asarray(mu[::-1][:count])


def _symmetric(A: Array) -> Array:
    return np.asarray(0.5 * (A + A.T))


def _error(coarse: Array, fine: Array) -> Array:
    difference = REST * (coarse - fine)
    return np.asarray(difference / (coarse - difference))
