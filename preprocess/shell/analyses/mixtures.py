"""Planes above the lowest eigenvalue of a shell, over mixtures of lay-ups (bound.py)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.optimize import linprog

from ....solver.math.arrays import Array
from ....solver.package.shell.plies import PATTERNS, harmonics, ply_factors
from ...laminate.report import is_symmetric
from ...laminate.stiffness import Laminate
from ..shell_cells import ShellError

ROUNDING = 1e-9  # relative: a smaller parameter is a sum that cancels
MODES = 6  # most cutting planes of one mixture
MOST_KEPT = 100  # cutting planes, those nearest to the best mixture
AGREED = 1e-5  # relative difference of the linear program and lambda
CLOSE = 1.5  # times the lowest value: modes that give cutting planes
COARSE, FINE = np.arange(-90.0, 90.0, 5.0), np.arange(-90.0, 90.0, 0.05)  # [deg]
# Largest error of the maximum of each harmonic on FINE.
BETWEEN = 0.5 * np.array([4.0, 4.0, 16.0, 16.0]) * np.radians(0.5 * (FINE[1] - FINE[0])) ** 2


class Plies:
    """Plies at any angle; mirrored ones of a symmetric laminate have the same.

    Attributes
    ----------
    mean : A, B, D at p = 0, (3, 3, 3) [N/m, N, N m]
    rows : plies of each angle
    columns : (g, 12, 4) parameters p per harmonic of each angle, in the order A, B, D
    """

    def __init__(self, laminate: Laminate) -> None:
        H, k = laminate.moments, len(laminate.plies)
        self.symmetric = is_symmetric(laminate)
        mean, u = ply_factors([ply.material for ply in laminate.plies])
        self.mean: Array = np.einsum("nl,lij->nij", H, mean)
        own = np.einsum("nl,lh,hj->lnhj", H, u, np.eye(4)).reshape(k, 12, 4)
        mirrored = [sorted({i, k - 1 - i}) for i in range((k + 1) // 2)]
        rows = mirrored if self.symmetric else [[i] for i in range(k)]
        columns = np.array([own[each].sum(axis=0) for each in rows])
        size = np.repeat(np.abs(H).max(axis=1), 4)[:, None] * np.abs(mean).max()
        columns[np.abs(columns) < ROUNDING * size] = 0.0
        kept = np.flatnonzero(np.abs(columns).max(axis=(1, 2)))  # the others have no direction
        self.rows, self.columns = [rows[i] for i in kept], columns[kept]

    def parameters(self, angles_deg: Array) -> Array:
        """Parameters (12,) of a lay-up of angles (g,)."""
        return np.asarray(np.einsum("gjh,gh->j", self.columns, harmonics(angles_deg)))

    def stiffness(self, p: Array) -> Array:
        """A, B, D of parameters (12,), (3, 3, 3)."""
        return self.mean + np.einsum("nh,hij->nij", p.reshape(3, 4), PATTERNS)


class Mixture(NamedTuple):
    """The best mixture for some cutting planes: its parameters, the angles of its largest shares,
    and a bound of lambda of all lay-ups."""

    p: Array  # (12,)
    angles_deg: Array  # (g,)
    bound: float


class Cuts:
    """Linear functions c + q.p above lambda of all lay-ups."""

    def __init__(self, plies: Plies) -> None:
        self._columns, self._angles = plies.columns, COARSE
        self._c, self._q = np.zeros(0), np.zeros((0, 12))

    def add(self, c: Array, q: Array) -> None:
        """More of them, (k,) and (k, 12)."""
        self._c, self._q = np.concatenate([self._c, c]), np.concatenate([self._q, q])

    def best(self, angles_deg: Sequence[Array] | None = None) -> Mixture:
        """The mixture whose least function is largest.

        Parameters
        ----------
        angles_deg : those that each ply may have; None for any
        """
        scale = float(np.abs(self._c).max())
        own = [self._angles] * len(self._columns) if angles_deg is None else angles_deg
        g = np.repeat(np.arange(len(own)), [len(each) for each in own])
        a = np.concatenate(own)
        at = np.einsum("ajh,ah->ja", self._columns[g], harmonics(a))  # p of each ply and angle
        optimum = linprog(
            np.append(np.zeros(len(a)), -1.0),
            A_ub=np.c_[-(self._q / scale) @ at, np.ones(len(self._q))],
            b_ub=self._c / scale,
            A_eq=np.c_[np.arange(len(own))[:, None] == g, np.zeros(len(own))],
            b_eq=np.ones(len(own)),
            bounds=[(0.0, None)] * len(a) + [(None, None)],
        )
        if optimum.status:
            raise ShellError(f"bound: the linear program failed: {optimum.message}")
        s = np.maximum(-optimum.ineqlin.marginals, 0.0)
        s /= s.sum()
        combined = np.einsum("i,ij,gjh->gh", s, self._q, self._columns)
        shares, fine = optimum.x[:-1], own if angles_deg is not None else [FINE] * len(own)
        values = [harmonics(each) @ row for each, row in zip(fine, combined, strict=True)]
        largest = sum(float(each.max()) for each in values)
        if angles_deg is None:
            largest += float((np.abs(combined) @ BETWEEN).sum())
            more = a[shares > ROUNDING], FINE[[int(each.argmax()) for each in values]]
            self._angles = np.unique(np.concatenate([COARSE, *more]))
        p = at @ shares
        near = np.argsort(self._c + self._q @ p)[:MOST_KEPT]
        bound = float(s @ self._c) + largest
        self._c, self._q = self._c[near], self._q[near]
        chosen = [a[g == k][shares[g == k].argmax()] for k in range(len(own))]
        return Mixture(p, np.array(chosen), bound)


class Basis:
    """The shell in a basis of modes X (n_dof, m), linearised about a mixture.

    Parameters
    ----------
    p, K, slopes : the mixture, its stiffness and the derivatives of that by some parameters
    W : (m, m) X'W X
    """

    def __init__(
        self, X: Array, W: Array, p: Array, K: sp.csr_matrix, slopes: dict[int, sp.csr_matrix]
    ) -> None:
        size, axes = scipy.linalg.eigh(X.T @ (K @ X))
        kept = size > ROUNDING * size[-1]
        T = axes[:, kept] / np.sqrt(size[kept])
        X = X @ T
        self._G = np.zeros((12, *T.shape[1:], *T.shape[1:]))
        for j, slope in slopes.items():
            self._G[j] = X.T @ (slope @ X)
        self._W, self._K = T.T @ W @ T, np.eye(T.shape[1]) - np.tensordot(p, self._G, 1)

    def value(self, p: Array) -> float:
        """Lambda of parameters (12,)."""
        last = [len(self._W) - 1] * 2
        K = self._K + np.tensordot(p, self._G, 1)
        return float(1.0 / scipy.linalg.eigvalsh(self._W, K, subset_by_index=last)[0])

    def cuts(self, p: Array) -> tuple[Array, Array]:
        """Functions c + q.p, (k,) and (k, 12), of the lowest modes at parameters p."""
        mu, Y = scipy.linalg.eigh(self._W, self._K + np.tensordot(p, self._G, 1))
        Y = (Y / np.sqrt(np.abs(mu)))[:, mu > mu[-1] / CLOSE][:, -MODES:]
        c = np.einsum("mi,mn,ni->i", Y, self._K, Y)
        return c, np.einsum("mi,jmn,ni->ij", Y, self._G, Y, optimize=True)
