"""Linear buckling: load factors at which a prestressed shell has no stiffness left.

With the geometric stiffness Kg of the resultants of a load case, (K + lambda Kg) x = 0. K is
definite and Kg is not, so the problem solved is -Kg x = mu K x, mu = 1/lambda, from its largest mu:
all load factors are found, however small. The number of negative pivots of K + s Kg, with s
above the last factor, is the correct number of factors.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh

from ....solver.errors import check_known, coded
from ....solver.math.arrays import Array
from ... import fenicsx
from ...fenicsx.team import whole
from ..model.freedom import Freedom
from ..model.shell_problem import ShellProblem, mode_count
from ..model.shell_warnings import Warnings, check_supported
from ..shell_cells import ShellError
from .frequencies import GAP, signs

TOLERANCE = 1e-10
NONE = 1e-4  # of the largest |mu|: a smaller one is a local effect or round-off
REVERSED = 1e-2  # the same, of the reversed load
FEW, MANY = 14, 20  # least number of Krylov vectors: for the size of mu, for the factors
ABOVE = 1.05  # level above all mu, over their size
MOST = 100  # restarts of the iteration
TRIES = 4  # with more factors each time, if some were missed
DENSE = 400  # unknowns, below which all factors are computed


class LoadFactors(NamedTuple):
    """Load factors of one load case, ascending, with their shapes."""

    values: Array  # (m,) above 0
    shapes: Array  # (n_dof, m) largest displacement 1
    reversed: float  # the smallest factor, below 0, of the reversed load; 0 if there is none


class Buckling:
    """Load factors of a shell under several load cases, with one factorisation of its stiffness.

    Parameters
    ----------
    K : stiffness, with that of constant loads, of all degrees of freedom
    where : the table, for messages

    Raises
    ------
    ShellError : K is not definite.
    """

    def __init__(
        self, K: sp.csr_matrix, freedom: Freedom, where: str, team: fenicsx.Team = fenicsx.ALONE
    ) -> None:
        self._K, self._freedom, self._team = freedom.reduced(K), freedom, team
        try:
            self._factor = fenicsx.cholesky(self._K, team)
        except fenicsx.FactorisationError as error:
            raise ShellError(
                f"{where}: {error} Buckling needs supports that prevent rigid motions, and "
                "constant loads below their own load factor"
            ) from error

    def close(self) -> None:
        """Free the memory of the factors."""
        self._factor.close()

    def load_factors(self, Kg: sp.csr_matrix, count: int, where: str) -> LoadFactors:
        """The smallest load factors of a load case.

        Parameters
        ----------
        Kg : geometric stiffness of the load case that is multiplied, of all degrees of freedom
        count : requested factors; fewer are returned if there are not as many
        where : the load case, for messages

        Raises
        ------
        ShellError : the iteration does not converge, or misses factors.
        """
        freedom = self._freedom
        G = freedom.reduced(-Kg)
        if not self._team.total(np.array([float(G.nnz)])).any():
            return LoadFactors(np.zeros(0), np.zeros((freedom.n_dof, 0)), 0.0)
        try:
            wanted = count
            for _ in range(TRIES):
                mu, X, back = self._both_ends(G, wanted)
                values = 1.0 / mu
                last = _level(values, count)
                negative = self._negative(last * G) if len(values) else 0
                below = int(np.count_nonzero(values < last))
                if negative == below:
                    break
                # the iteration may miss one of two equal factors, as of a full cylinder
                wanted = max(2 * wanted, negative + 2)
        except (
            ArpackError,
            ArpackNoConvergence,
            fenicsx.FactorisationError,
            fenicsx.InertiaError,
        ) as error:
            raise ShellError(f"{where}: buckling: {error}") from error
        if negative != below:
            raise ShellError(
                f"{where}: {negative} load factors are below {last:.6g}, the iteration found "
                f"{below}; "
                "ask for more of them (buckling.count)"
            )
        shapes = freedom.expanded(X[:, :count])
        if not len(values):
            return LoadFactors(values, shapes, back)
        size = np.abs(shapes.reshape(-1, 6, shapes.shape[1])[:, :3]).max(axis=(0, 1), initial=0.0)
        shapes = shapes * signs(shapes, freedom) / np.where(size > 0.0, size, 1.0)
        return LoadFactors(values[:count], shapes, back)

    def _both_ends(self, G: sp.csr_matrix, count: int) -> tuple[Array, Array, float]:
        """The largest mu > 0 of G x = mu K x, descending, one more than requested; their x (n, m)
        with x'K x = 1; the smallest factor of the reversed load, 0 if none is of interest."""
        n = G.shape[0]
        if n <= max(DENSE, 3 * count):
            mu, X = scipy.linalg.eigh(*(whole(part, self._team).toarray() for part in (G, self._K)))
            size = np.abs(mu).max(initial=0.0)
            order = np.flatnonzero(mu > NONE * size)[::-1][: count + 1]
            back = 1.0 / mu[0] if mu[0] < -REVERSED * size else 0.0
            return mu[order], X[:, order], float(back)
        # the largest |mu| to about three digits, which is less work than the factors
        lanczos = self._iterated(G, 1, 1e-3, FEW, Minv=self._operator(self._factor.solve))
        extreme = float(lanczos[0][0])
        size, mu, X = abs(extreme), np.zeros(0), np.zeros((n, 0))
        if extreme > 0.0 or self._negative(G / (NONE * size)):
            mu, X = self._largest(G, count + 1, size)
            order = np.argsort(-mu)
            order = order[mu[order] > NONE * size]
            mu, X = mu[order], X[:, order]
        if extreme > 0.0 and not self._negative(-G / (REVERSED * size)):
            return mu, X, 0.0
        try:
            back = -float(self._largest(-G, 1, size)[0][0])
        except ArpackNoConvergence:
            back = 0.0
        return mu, X, 1.0 / back if back < -REVERSED * size else 0.0

    def _negative(self, scaled: sp.csr_matrix) -> int:
        return fenicsx.negative_pivots(self._K - scaled, self._team)

    def _largest(self, G: sp.csr_matrix, count: int, size: float) -> tuple[Array, Array]:
        """The largest mu and their x: the nearest ones to a level just above all of them.

        Inverse iteration there takes a factorisation more, and a fourth of the steps.
        """
        level = ABOVE * size
        factor = fenicsx.Cholesky(level * self._K - G, self._team, definite=False)
        inverse = self._operator(lambda x: -factor.solve(x))
        try:
            return self._iterated(G, count, TOLERANCE, MANY, sigma=level, OPinv=inverse)
        finally:
            factor.close()

    def _operator(self, product: Callable[[Array], Array]) -> LinearOperator:
        return LinearOperator(self._K.shape, product, dtype=float)

    def _iterated(
        self, G: sp.csr_matrix, count: int, tolerance: float, least: int, **by: Any
    ) -> tuple[Array, Array]:
        """Lanczos iteration `by` an inverse, from a start that runs reproduce."""
        total = self._team.total
        applied = self._operator(lambda x: total(G @ x))
        stiffness = self._operator(lambda x: total(self._K @ x))
        mu, X = eigsh(
            applied, count, M=stiffness, **by, which="LM", tol=tolerance, ncv=max(3 * count, least),
            maxiter=MOST, v0=np.random.default_rng(0).standard_normal(G.shape[0]),
        )  # fmt: skip
        return mu, X


def _level(values: Array, count: int) -> float:
    """A level above the requested factors, in a gap behind them if there is one."""
    if not len(values):
        return 0.0
    last = min(count, len(values)) - 1
    if last + 1 < len(values) and values[last + 1] - values[last] > GAP * values[last + 1]:
        return 0.5 * float(values[last] + values[last + 1])
    return float(values[-1]) * (1.0 + GAP)


LARGE = 0.1  # rad, rotation at the first load factor above which linear buckling is doubtful
IN_PLANE = 0.1  # out of the plane over the largest motion: less is a motion in the plane
FLAT = 1e-6  # height of a flat shell over its size


class Stressed:
    """A shell with the displacements of its load cases.

    Parameters
    ----------
    names : of the load cases
    u : (n_dof, l) their displacements
    """

    def __init__(self, problem: ShellProblem, names: Sequence[str], u: Array) -> None:
        self.problem, self.names, self.u = problem, tuple(names), u

    def geometric(self, case: str, where: str, in_plane: bool = True) -> sp.csr_matrix:
        """Geometric stiffness of a load case, with that of its pressures, which follow the surface.

        Parameters
        ----------
        case : name of the load case
        where : key that names it, for messages
        in_plane : stresses do work on rotations about the normal

        Raises
        ------
        ShellError
            An unknown case.
        """
        problem, row = self.problem, self._row(case, where)
        Kg = problem.geometric_stiffness(self.u[:, row], in_plane)
        loads = problem.spec["loads"][case]
        p = problem.loads.pressures(loads, f"{problem.where}.loads.{case}")
        if not p.any():
            return Kg
        return sp.csr_matrix(Kg + problem.pressure_stiffness(p))

    def stiffness(self, case: str | None, where: str, in_plane: bool = True) -> sp.csr_matrix:
        """Stiffness (n_dof, n_dof) under a load case.

        Parameters
        ----------
        case : name of the load case; None: the unloaded shell
        where, in_plane : as of `geometric`
        """
        if case is None:
            return self.problem.K
        return sp.csr_matrix(self.problem.K + self.geometric(case, where, in_plane))

    def rotation(self, case: str) -> float:
        """Largest rotation in a load case [rad]."""
        turned = self.u[:, self.names.index(case)].reshape(-1, 6)[:, 3:]
        return float(np.linalg.norm(turned, axis=1).max(initial=0.0))

    def _row(self, case: str, where: str) -> int:
        known = ", ".join(self.names) or "those of tables loads.CASE"
        text = f"no load case of that name; expected one of {known}"
        check_known(case, self.names, where, ShellError, text)
        return self.names.index(case)


def check_stable(K: sp.csr_matrix, problem: ShellProblem, case: str, where: str) -> None:
    """Check that the shell has not buckled under the stresses of a load case.

    Parameters
    ----------
    K : (n, n) its stiffness of the free degrees of freedom, without free motions
    problem : the shell
    case : name of the load case
    where : key that names it, for messages

    Raises
    ------
    ShellError
        It has buckled, or K cannot be factorised.
    """
    try:
        negative = fenicsx.negative_pivots(K, problem.team)
    except fenicsx.InertiaError as error:
        raise ShellError(f"{where} = {case!r}: {error}") from error
    if negative:
        raise buckled(case, where)


def buckled(case: str, where: str) -> ShellError:
    """The error of a shell that does not vibrate about its prestress."""
    return ShellError(
        f"{where} = {case!r}: the shell has buckled under this load case and does not vibrate; "
        "expected a smaller load: its load factor, which `--buckling` gives, has to be above 1"
    )


def buckling(
    stressed: Stressed, table: Mapping[str, Any], where: str, warnings: Warnings
) -> dict[str, LoadFactors]:
    """Load factors of load cases by name.

    Parameters
    ----------
    table : {"count": 4, "cases": [..], "constant": case, "in_plane": true}, all optional: number
        of factors; load cases that are multiplied, all of them by default except the constant
        one; a load case whose stress is constant; work on rotations about the normal
    where : key of the table, for messages
    warnings : appended to

    Raises
    ------
    ShellError : no load case, an unknown one, free rigid motions.
    """
    problem = stressed.problem
    count, in_plane = mode_count(table, where, 4), table.get("in_plane", True)
    constant = table.get("constant")
    cases = table.get("cases")
    if cases is None:
        cases = [name for name in stressed.names if name != constant]
    if not cases:
        raise ShellError(f"{where}: expected load cases, tables loads.CASE.NAME")
    freedom = problem.modes_freedom
    check_supported(freedom, *problem.free_motions(freedom))
    K = stressed.stiffness(constant, f"{where}.constant", in_plane)
    equations = Buckling(K, freedom, where, problem.team)
    factors = {}
    for name in cases:
        Kg = stressed.geometric(name, f"{where}.cases", in_plane)
        factors[name] = equations.load_factors(Kg, count, f"{where}, load case {name}")
        first = factors[name].values[:1]
        turned = stressed.rotation(name) * float(first[0]) if len(first) else 0.0
        if turned > LARGE:
            warnings += coded(
                "buckling-after-large-rotation",
                f"load case {name}: at the load factor {first[0]:.4g} the shell has turned by "
                f"{np.degrees(turned):.3g} deg, more than {np.degrees(LARGE):.3g}: linear buckling "
                "assumes small displacements up to buckling; the real load may be far below",
            )
        if len(first) and _moves_in_plane(problem.mesh.points_G, factors[name].shapes[:, 0]):
            warnings += coded(
                "buckles-in-plane",
                f"load case {name}: the mode of the factor {first[0]:.4g} moves in the plane of "
                "the shell: a column, or a rotation that supports hold at one node only (hold the "
                "plane at two nodes); in_plane = false leaves such modes out",
            )
    equations.close()
    return factors


def _moves_in_plane(points_G: Array, shape: Array) -> bool:
    """Whether a flat shell with nodes (n, 3) has a mode (6 n,) in its plane."""
    away = points_G - points_G.mean(axis=0)
    size, axes = np.linalg.svd(away, full_matrices=False)[1:]
    motion = shape.reshape(-1, 6)[:, :3]
    out = float(np.abs(motion @ axes[2]).max())
    return bool(size[2] < FLAT * size[0] and out < IN_PLANE * np.abs(motion).max())
