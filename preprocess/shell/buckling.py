"""Linear buckling: load factors at which a prestressed shell has no stiffness left.

With the geometric stiffness Kg of the resultants of a load case, (K + lambda Kg) x = 0. K is
definite and Kg is not, so the problem solved is -Kg x = mu K x, mu = 1/lambda, from its largest mu:
all load factors are found, however small. The number of negative pivots of K + s Kg, with s
above the last factor, is the correct number of factors.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence, LinearOperator, eigsh

from ...solver.math.arrays import Array
from .. import fenicsx
from .errors import ShellError
from .freedom import Freedom
from .frequencies import GAP, signs

TOLERANCE = 1e-10
NONE = 1e-4  # of the largest |mu|: a smaller one is a local effect or round-off
REVERSED = 1e-2  # the same, of the reversed load
MOST = 100  # restarts of the iteration
DENSE = 400  # unknowns, below which all factors are computed


class LoadFactors(NamedTuple):
    """Load factors of one load case, ascending, with their shapes."""

    values: Array  # (m,) above 0
    shapes: Array  # (n_dof, m) largest displacement 1
    reversed: float  # the smallest factor, below 0, of the reversed load; 0 if there is none


def load_factors(
    K: sp.csr_matrix,
    Kg: sp.csr_matrix,
    freedom: Freedom,
    count: int,
    where: str,
    team: fenicsx.Team = fenicsx.ALONE,
) -> LoadFactors:
    """The smallest load factors.

    Parameters
    ----------
    K, Kg : stiffness, with that of constant loads, and geometric stiffness of the load case that
        is multiplied, both of all degrees of freedom
    count : requested factors; fewer are returned if there are not as many
    where : the load case, for messages

    Raises
    ------
    ShellError : K is not definite, or the iteration does not converge.
    """
    K_free, G_free = freedom.reduced(K), freedom.reduced(-Kg)
    if not G_free.nnz:
        return LoadFactors(np.zeros(0), np.zeros((freedom.n_dof, 0)), 0.0)
    try:
        factor = fenicsx.Cholesky(K_free, team)
        mu, X = _largest(K_free, G_free, factor, count + 1)
        back = _reversed(K_free, -G_free, factor)
        factor.close()
        values = 1.0 / mu
        last = _level(values, count)
        found = fenicsx.negative_pivots(K_free - last * G_free, team) if len(values) else 0
        below = int(np.count_nonzero(values < last))
    except fenicsx.FactorisationError as error:
        raise ShellError(
            f"{where}: {error} Buckling needs supports that prevent rigid motions, and "
            "constant loads below their own load factor"
        ) from error
    except (ArpackError, ArpackNoConvergence, fenicsx.InertiaError) as error:
        raise ShellError(f"{where}: buckling: {error}") from error
    if found != below:
        raise ShellError(
            f"{where}: {found} load factors are below {last:.6g}, the iteration found {below}; "
            "ask for more of them (buckling.count)"
        )
    shapes = freedom.expanded(X[:, :count])
    if not len(values):
        return LoadFactors(values, shapes, back)
    size = np.abs(shapes.reshape(-1, 6, shapes.shape[1])[:, :3]).max(axis=(0, 1), initial=0.0)
    shapes = shapes * signs(shapes, freedom) / np.where(size > 0.0, size, 1.0)
    return LoadFactors(values[:count], shapes, back)


def _reversed(K: sp.csr_matrix, G: sp.csr_matrix, factor: fenicsx.Cholesky) -> float:
    """The smallest factor of the reversed load, below 0; 0 if none is of a size of interest."""
    try:
        mu, _ = _largest(K, G, factor, 1, REVERSED)
    except ArpackNoConvergence:
        return 0.0
    return -1.0 / float(mu[0]) if len(mu) else 0.0


def _largest(
    K: sp.csr_matrix,
    G: sp.csr_matrix,
    factor: fenicsx.Cholesky,
    count: int,
    least: float = NONE,
) -> tuple[Array, Array]:
    """The largest mu > 0 of G x = mu K x, descending, and their x (n, m) with x'K x = 1."""
    n = K.shape[0]
    if n <= max(DENSE, 3 * count):
        mu, X = scipy.linalg.eigh(G.toarray(), K.toarray())
        order = np.flatnonzero(mu > least * np.abs(mu).max(initial=0.0))[::-1][:count]
        return mu[order], X[:, order]
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(n)
    options = {"M": K, "Minv": inverse, "v0": start, "ncv": max(3 * count, 40)}
    options["maxiter"] = MOST
    size = abs(float(eigsh(G, 1, which="LM", tol=1e-3, **options)[0][0]))
    if not fenicsx.negative_pivots(K - G / (least * size)):
        return np.zeros(0), np.zeros((n, 0))
    mu, X = eigsh(G, count, which="LA", tol=TOLERANCE, **options)
    order = np.argsort(-mu)
    order = order[mu[order] > least * size]
    return mu[order], X[:, order]


def _level(values: Array, count: int) -> float:
    """A level above the requested factors, in a gap behind them if there is one."""
    if not len(values):
        return 0.0
    last = min(count, len(values)) - 1
    if last + 1 < len(values) and values[last + 1] - values[last] > GAP * values[last + 1]:
        return 0.5 * float(values[last] + values[last + 1])
    return float(values[-1]) * (1.0 + GAP)
