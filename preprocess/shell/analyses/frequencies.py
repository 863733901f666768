"""Natural frequencies and shapes of a shell, supported or free.

Shift and invert at zero if the supports prevent all rigid motions; otherwise the shift is
negative, of the size of the lowest elastic value. A Krylov iteration may return only one of
two modes of equal frequency. The number of negative pivots of K - s M, with s above the last kept
mode, is the correct number of modes.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from ....solver.math.arrays import Array
from ... import fenicsx
from ..model.freedom import Freedom
from ..shell_cells import ShellError

EXTRA = 1  # modes beyond the requested ones, to find a gap
TOLERANCE = 1e-10  # of the iteration; the error of a value is its square
GAP = 1e-4  # relative distance of two values between which the modes are counted
ZERO = 1e-6  # of the lowest elastic value: a mode below it is not a vibration
ROUNDING = 1e-13  # of |x|'|K||x|: x'Kx below it is rounding


class Frequencies(NamedTuple):
    """The lowest `m` modes, unit modal mass."""

    values: Array  # (m,) squared circular frequencies      [rad2/s2]
    shapes: Array  # (n_dof, m)                             [m, rad per sqrt(kg) m]
    n_zero: int  # number of modes without strain energy, which come first
    n_free_motions: int  # expected number of these: free rigid motions and known mechanisms


def natural_modes(
    K: sp.csr_matrix,
    M: sp.csr_matrix,
    freedom: Freedom,
    count: int,
    free_motions: Array,
    team: fenicsx.Team = fenicsx.ALONE,
) -> Frequencies:
    """Modes without strain energy, then the lowest elastic modes.

    Parameters
    ----------
    K, M : stiffness and mass of all degrees of freedom; each process of a team has its part
    count : requested elastic modes
    free_motions : (n_dof, k) free motions without strain energy

    Raises
    ------
    ShellError : fewer modes than requested, or modes that do not converge.
    """
    K_free, M_free = freedom.reduced(K), freedom.reduced(M)
    n_free_motions = free_motions.shape[1]
    target = 0.0
    if n_free_motions:
        target = -_soft_value(K_free, M_free, free_motions[freedom.free], team)
    wanted = count + n_free_motions
    try:
        massive = int(np.count_nonzero(team.total(np.diff(M_free.indptr))))
        n_mode = min(wanted + EXTRA, massive)
        while True:
            values, X = fenicsx.eigenpairs(
                K_free, M_free, n_mode, target=target, tolerance=TOLERANCE, team=team
            )
            if n_mode == massive:
                break
            level, below = _gap(values, wanted)
            negative = fenicsx.negative_pivots(K_free - level * M_free, team)
            if negative <= below:
                break
            # a repetition with the same number of modes would miss the same one
            n_mode = min(max(n_mode, negative) + EXTRA, massive)
    except (fenicsx.EigenError, fenicsx.InertiaError) as error:
        raise ShellError(f"frequencies: {error}") from error
    n_zero = _without_energy(K_free, values, X, n_free_motions, team) if n_free_motions else 0
    values, X = values[:wanted], X[:, :wanted]
    shapes = freedom.expanded(X)
    return Frequencies(values, shapes * signs(shapes, freedom), n_zero, n_free_motions)


def _without_energy(
    K: sp.csr_matrix, values: Array, X: Array, n_free_motions: int, team: fenicsx.Team
) -> int:
    """How many of the modes X (n, m), unit modal mass, have no strain energy.

    The membrane stiffness of a thin shell is much larger than its bending stiffness. The round-off
    in x'Kx of a rigid motion may therefore be 1e-4 of the lowest elastic value, of either sign.
    """
    lowest = abs(values[n_free_motions] if n_free_motions < len(values) else values[-1])
    rounding = ROUNDING * np.einsum("nm,nm->m", np.abs(X), team.total(abs(K) @ np.abs(X)))
    return int(np.count_nonzero(np.abs(values) < np.maximum(ZERO * lowest, rounding)))


def _soft_value(
    K: sp.csr_matrix, M: sp.csr_matrix, free_motions: Array, team: fenicsx.Team = fenicsx.ALONE
) -> float:
    """Estimate of the lowest elastic eigenvalue of a structure with the motions `free_motions`.

    Rayleigh quotient of its shape under a random load, with as many held degrees of freedom as
    there are motions. The second load is the inertia of the first shape.
    """
    _, _, pivots = scipy.linalg.qr(free_motions.T, mode="economic", pivoting=True)
    held = pivots[: free_motions.shape[1]]
    rest = np.setdiff1d(np.arange(K.shape[0]), held)
    load = team.total(M @ np.random.default_rng(0).standard_normal(K.shape[0]))
    shape = np.zeros(K.shape[0])
    try:
        factor = fenicsx.Cholesky(K[rest][:, rest], team)
        for _ in range(2):
            shape[rest] = factor.solve(load[rest])
            load = team.total(M @ shape)
            load /= np.abs(load).max()
        factor.close()
    except fenicsx.FactorisationError as error:
        raise ShellError(f"frequencies: {error}") from error
    return float(shape @ team.total(K @ shape) / (shape @ team.total(M @ shape)))


def _gap(values: Array, wanted: int) -> tuple[float, int]:
    """A level between two distinct values above the requested ones, and the number of values below.

    If the last values are equal, the level is above all of them.
    """
    for n in range(wanted, len(values)):
        if values[n] - values[n - 1] > GAP * abs(values[n]):
            return 0.5 * float(values[n] + values[n - 1]), n
    return float(values[-1]) * (1.0 + GAP), len(values)


def signs(shapes: Array, freedom: Freedom) -> Array:
    """+1 or -1 for each mode: the largest displacement is positive; of equal ones, the first in the
    order of the file."""
    nodes = shapes.reshape(-1, 6, shapes.shape[1])[: freedom.mesh.n_node, :3]
    table = nodes.reshape(-1, shapes.shape[1])
    size = np.abs(table)
    first = np.argmax(size >= (1.0 - 1e-3) * size.max(axis=0), axis=0)
    sign = np.sign(table[first, np.arange(table.shape[1])])
    return np.where(sign == 0.0, 1.0, sign)
