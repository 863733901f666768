"""Derivatives of the modes of a body by parameters of its stiffness and mass.

The eigenmodes have the derivatives of Nelson: K' and M' are those of the parameter,

    (K - lambda_i M) x_i' = -(K' - lambda_i M') x_i + M X_c L_c',    X_c' M x_i' = -1/2 X_c' M' x_i

with the cluster c of eigenvalues close to lambda_i. Its modes do not turn into each other; the
derivative L_c' = X_c' K' X_c - 1/2 (lambda_i + lambda_j) X_c' M' X_c of the modal stiffness is
therefore a full matrix. Modes that are not selected and close to a selected one turn with it.
Static shapes have the derivative K^-1 (f' - K' u). Static modes are the combinations of
eigenmodes and static shapes that the package has, orthonormal again to first order.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg

from ...solver.math.arrays import Array, IntArray
from .eigenmodes import COINCIDENT
from .reduced import Modes
from .reference import Condition, ModeError

CLOSE = 1e-3  # relative distance of eigenvalues within a cluster
SAME = 1e-10  # relative distance of eigenvalues that share a factorisation
TURNED = 1e-6  # coupling with a mode of equal frequency, relative to the change of an eigenvalue


@dataclass(frozen=True)
class Change:
    """Derivatives of the FE model by one parameter.

    Attributes
    ----------
    name : of the parameter
    K, M : (n_dof, n_dof) sparse, stiffness and mass
    forces, accelerations : (n_dof, l + u) of the static loads, then of the unit loads
    """

    name: str
    K: Any
    M: Any
    forces: Array
    accelerations: Array


@dataclass(frozen=True)
class ModeRates:
    """Derivatives of `Modes` by one parameter.

    Attributes
    ----------
    stiffness : (m, m) modal stiffness [1/s2]; the modal mass stays the unit matrix
    columns_B, accelerations_B : (n_dof, m)
    compliance : (u, u) of the unit loads
    """

    stiffness: Array
    columns_B: Array
    accelerations_B: Array
    compliance: Array


def mode_rates(condition: Condition, modes: Modes, changes: Sequence[Change]) -> list[ModeRates]:
    """Derivatives of modes by parameters.

    Parameters
    ----------
    condition : reference condition of the body
    modes : of the body, with their static shapes
    changes : derivatives of the FE model by each parameter

    Raises
    ------
    ModeError
        A parameter couples a selected mode with one of equal frequency that is not selected.
    """
    assert modes.static is not None
    assert modes.combination is not None
    n_eigen = modes.kinds.count("fixed_normal")
    X, S = modes.columns_B[:, :n_eigen], modes.columns_B[:, n_eigen:]
    values, stiff = modes.values[:n_eigen], modes.values[n_eigen:]
    n_load = len(modes.combination) - n_eigen
    turned = _eigen_rates(condition, modes, n_eigen, changes)
    static, rates = modes.static, []
    loads = [condition.load_rates(static, c.M, c.forces, c.accelerations) for c in changes]
    needed = [
        (F - c.K @ static.columns)[:, :n_load] for (_, F), c in zip(loads, changes, strict=True)
    ]
    shapes = np.zeros((len(X), n_load * len(changes)))
    if n_load:
        right = np.hstack(needed)
        shapes = condition.static(right, np.zeros_like(right)).columns
    MX, MS = condition.M @ X, condition.M @ S
    force = static.loads[:, :n_load] @ modes.combination[n_eigen:]
    force += MX * values @ modes.combination[:n_eigen]
    for row, (change, (dX, dL), (da, _)) in enumerate(zip(changes, turned, loads, strict=True)):
        U = static.columns
        dU = shapes[:, row * n_load : (row + 1) * n_load]
        dU = dU + condition.relief(change.M @ U[:, :n_load])
        dA = dX * values + X @ dL
        dY = np.hstack([dX, dU]) @ modes.combination
        dB = np.hstack([dA, da[:, :n_load]]) @ modes.combination
        E = -(MX.T @ dY + dX.T @ MS + X.T @ (change.M @ S))
        N, G = MS.T @ dY, force.T @ dY
        N, G = N + N.T + S.T @ (change.M @ S), G + G.T + S.T @ (change.K @ S)
        R = G - 0.5 * (N * stiff + stiff[:, None] * N)
        W, R = _turning(stiff, R)
        T = W - 0.5 * N
        own = X * values
        unit = change.forces + change.M @ static.accelerations  # what balances it does no work
        C = U[:, n_load:].T @ unit[:, n_load:]
        C = C + C.T - U[:, n_load:].T @ (change.K @ U[:, n_load:])
        rates.append(
            ModeRates(
                scipy.linalg.block_diag(dL, 0.5 * (R + R.T)),
                np.hstack([dX, dY + X @ E + S @ T]),
                np.hstack([dA, dB + own @ E + modes.accelerations_B[:, n_eigen:] @ T]),
                0.5 * (C + C.T),
            )
        )
    return rates


def _eigen_rates(
    condition: Condition, modes: Modes, n_eigen: int, changes: Sequence[Change]
) -> list[tuple[Array, Array]]:
    """Derivatives of the columns (n_dof, n_eigen) and of the modal stiffness, per change."""
    others = modes.others or (np.zeros(0), np.zeros((len(modes.columns_B), 0)))
    values = np.concatenate([modes.values[:n_eigen], others[0]])
    X = np.hstack([modes.columns_B[:, :n_eigen], others[1]])
    rates = [(np.zeros_like(X[:, :n_eigen]), np.zeros((n_eigen, n_eigen))) for _ in changes]
    for rows in _clusters(values):
        kept = rows[rows < n_eigen]
        if not len(kept):
            continue
        Xc, MXc = X[:, rows], condition.M @ X[:, rows]
        K_rates = [Xc.T @ (c.K @ Xc) for c in changes]
        M_rates = [Xc.T @ (c.M @ Xc) for c in changes]
        mean = 0.5 * (values[rows] + values[rows][:, None])
        own = np.searchsorted(rows, kept)
        for (_, dL), K, M in zip(rates, K_rates, M_rates, strict=True):
            L = (K - mean * M)[np.ix_(own, own)]
            dL[np.ix_(kept, kept)] = 0.5 * (L + L.T)
        for group in _clusters(values[kept], SAME, kept):
            at = values[group]
            right = [
                -(c.K @ X[:, group]) + (c.M @ X[:, group]) * at for c in changes
            ]  # the loads of all parameters of all modes of one eigenvalue
            loads = np.hstack([r - MXc @ (Xc.T @ r) for r in right])
            moved = _bordered(condition, float(at.mean()), Xc, MXc, loads)
            for k, change in enumerate(changes):
                part = moved[:, k * len(group) : (k + 1) * len(group)]
                for column, i in enumerate(group):
                    turn = _shares(values, rows, i, n_eigen, K_rates[k], M_rates[k], change.name)
                    rates[k][0][:, i] = part[:, column] + Xc @ turn
    return rates


def _shares(
    values: Array, rows: IntArray, i: int, n_eigen: int, K: Array, M: Array, name: str
) -> Array:
    """Shares (c,) of the modes of a cluster in the derivative of its mode i.

    `K` and `M` (c, c) are the derivatives of the stiffness and mass in the modes of the cluster.
    """
    own = int(np.searchsorted(rows, i))
    turn = -0.5 * M[:, own]
    couple = K[:, own] - values[i] * M[:, own]
    largest = np.abs(np.diag(K) - values[rows] * np.diag(M)).max()
    for j, row in enumerate(rows):
        if row < n_eigen:
            continue
        apart = values[i] - values[row]
        if abs(apart) > COINCIDENT * values[i]:
            turn[j] = couple[j] / apart
        elif abs(couple[j]) > TURNED * max(largest, COINCIDENT * values[i]):
            raise ModeError(
                f"design.{name}: it couples a selected mode with one of the same frequency "
                f"({np.sqrt(values[i]):.6g} rad/s) that is not selected, so the selected mode has "
                "no derivative; request both in `modes`"
            )
    return turn


def _clusters(values: Array, close: float = CLOSE, of: IntArray | None = None) -> list[IntArray]:
    """Rows (or numbers `of` rows) of close values together, each ascending."""
    order = np.argsort(values, kind="stable")
    apart = np.diff(values[order]) > close * np.abs(values[order][1:])
    numbers = order if of is None else of[order]
    return [np.sort(part) for part in np.split(numbers, np.flatnonzero(apart) + 1)]


def _bordered(condition: Condition, value: float, X: Array, MX: Array, loads: Array) -> Array:
    """Solve (K - value M) x = load for x without parts along the modes X of a cluster.

    As many dofs as modes are solved last: without them the matrix is regular, and they follow
    from X' M x = 0 (Nelson).
    """
    free = condition.free
    A = (condition.K - value * condition.M).tocsr()[free][:, free]
    size = np.sqrt(np.abs(condition.K.diagonal()[free]))
    pinned = scipy.linalg.qr((X[free] * size[:, None]).T, pivoting=True, mode="r")[1]
    last = np.sort(pinned[: X.shape[1]])
    rest = np.setdiff1d(np.arange(len(free)), last)
    right = np.hstack([loads[free][rest], -A[rest][:, last].toarray()])
    solved = condition.algebra.solve_indefinite(A[rest][:, rest], right)
    x = np.zeros((len(loads), right.shape[1]))
    x[free[rest]] = solved
    count = loads.shape[1]
    x[free[last], count + np.arange(len(last))] = 1.0
    solution, null = x[:, :count], x[:, count:]
    return np.asarray(solution - null @ np.linalg.solve(MX.T @ null, MX.T @ solution))


def _turning(values: Array, rate: Array) -> tuple[Array, Array]:
    """Turning (k, k) of static modes that keeps their stiffness diagonal, and what is left of it.

    Modes of close values do not turn.
    """
    apart = values[:, None] - values
    near = np.zeros(apart.shape, dtype=bool)
    for rows in _clusters(values):
        near[np.ix_(rows, rows)] = True
    W = np.where(near, 0.0, -rate / np.where(near, 1.0, apart))
    return W, np.where(near, rate, 0.0)
