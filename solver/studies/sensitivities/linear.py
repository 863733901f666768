"""The equations of the tangent of a motion at known states, of independent coordinates.

They are differentiated along free motions, and along motions of the constraint rows that parameters
move. See tangent.py for the equations.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

from ...dynamics.evaluation.accelerations import masses_and_jacobians
from ...dynamics.evaluation.variations import along_directions, terms
from ...dynamics.model.coordinates import displaced
from ...dynamics.model.model import Model, modal_matrix
from ...math.arrays import Array, IntArray
from ...math.independent_changes import independent
from ..tolerances import LEAST_STEP, MOST_GROWTH, STEP

# Differences on both sides of a number, and changes for which there is time. `STEP` in place of
# BOTH for numbers of stops: a limit that moves by 1e-5 is on the other side of stages near impacts.
BOTH, FEW = 1e-5, 6
SAME = 1e-9  # of the largest change of a model, below which there is none: differences of packages
SLOW = 1e-6  # sizes of the mechanism per second, or rad/s: below, a state is at rest


class Column(NamedTuple):
    """A parameter: the model at its value less and plus h, treated like that of the run."""

    minus: Model
    plus: Model
    h: float


class Linear(NamedTuple):
    """w' = J w + g of independent coordinates w at k states, and what follows from them."""

    J: Array  # (k, m, m)
    g: Array  # (k, m, P)
    x: Array  # (k, n_vel, m) displacements x w + x_p
    x_p: Array  # (k, n_vel, P)
    v: Array  # (k, n_vel, m) changes of velocities v w + v_p
    v_p: Array  # (k, n_vel, P)
    kept: IntArray  # (m,) which of S are independent
    n_free: int


class Linearisation:
    """Linearises a model along its motion.

    Parameters
    ----------
    partials : derivatives of the terms by the parameters
    units : (n_vel,) of velocity coordinates as shares of the mechanism's size, or angles
    """

    def __init__(
        self, model: Model, partials: "Partials | Callable[..., Array]", units: Array
    ) -> None:
        self.model, self._partials, self._units = model, partials, units
        self._root = np.sqrt(model.inertia_scale)

    def __call__(
        self, t: Array, y: Array, a: Array, multipliers: Array, *, away: Array | None, last: bool
    ) -> Linear | None:
        """Return the equations of the independent coordinates at k states; see `_over`.

        Parameters
        ----------
        a, multipliers : (k, n_vel), (k, n_c)
        away : (k,) distance from bends of forces, in steps of differences; None without bends
        last : the partition is taken as it is
        """
        model, n, n_c, n_a = self.model, self.model.n_vel, self.model.n_constraint, self.model.n_aux
        M, Phi_q = masses_and_jacobians(model, t, y)
        middle = Phi_q[len(t) // 2] / self._root
        rows, dep, ind = partition(middle, n_c - model.redundant)
        Phi_q, f = Phi_q[:, rows], ind.size
        inverse = np.linalg.inv(Phi_q[:, :, dep])
        Z = np.zeros((t.size, n, f))
        Z[:, ind] = np.eye(f)
        Z[:, dep] = -inverse @ Phi_q[:, :, ind]
        growth = np.abs(Z * self._root[:, None] / self._root[ind]).max(initial=0.0)
        if not growth < MOST_GROWTH and not last:
            return None
        base = terms(model, t, y, a, multipliers)
        partial = self._partials(t, y, a, multipliers, base)
        # The rows that parameters move: their dependent motions X, at positions and velocities.
        phi, phi_d = (partial[:, :, n + which * n_c + rows].transpose(0, 2, 1) for which in (1, 2))
        moved = np.flatnonzero(phi.any(axis=(0, 2)) | phi_d.any(axis=(0, 2)))
        phi, phi_d = phi[:, moved], phi_d[:, moved]
        X = np.zeros((t.size, n, moved.size))
        X[:, dep] = inverse[:, :, moved]
        G = np.concatenate([Z, X], axis=2)
        # Body axes turn: -w x rotations is part of the rate of a displacement.
        rates, turning = y[:, model.n_pos : model.n_pos + n], np.zeros_like(G)
        for j in model.vel_start:
            own = slice(j + 3, j + 6)
            turning[:, own] = np.cross(rates[:, own, None], G[:, own], axis=1)
        # D Phidot along displacements: d(Phi_q x)/dt at constant x, less Phi_q of the turning.
        V = np.zeros_like(G)
        V[:, dep] = inverse @ (Phi_q @ turning - self._jacobian_rates(t, y, rows, Phi_q) @ G)
        d, none, G_t = G.shape[2], np.zeros((t.size, n, n_a)), G.transpose(0, 2, 1)
        directions = np.zeros((t.size, 2 * d + n_a, 2 * n + n_a))
        directions[:, :d, :n] = directions[:, d : 2 * d, n : 2 * n] = G_t
        directions[:, :d, n : 2 * n] = V.transpose(0, 2, 1)
        directions[:, 2 * d :, 2 * n :] = np.eye(n_a)
        steps, at = self._steps(rates, directions), (model, t, y, a, multipliers, directions)
        if away is None:
            along = along_directions(*at, steps)
        else:
            # Forward differences move the end of a contact by half a step. Most of the tangent
            # within it cancels at its end.
            steps *= np.clip(0.5 * away, LEAST_STEP, 1.0)[:, None]
            along = 0.5 * (along_directions(*at, steps) + along_directions(*at, -steps))
        phi_t, phi_d_t = (each.transpose(0, 2, 1) for each in (phi, phi_d))
        partial -= phi_t @ along[:, f:d] + phi_d_t @ along[:, d + f : 2 * d]
        every = np.concatenate(
            [along[:, :f], along[:, d : d + f], along[:, 2 * d :], partial], axis=1
        ).transpose(0, 2, 1)
        Z_M = Z.transpose(0, 2, 1) @ M
        # What the rows ask of dependent accelerations is taken from the loads.
        left = Z.transpose(0, 2, 1) @ every[:, :n] - (Z_M[:, :, dep] @ inverse) @ every[:, n + rows]
        free = np.linalg.solve(Z_M @ Z, left)
        x_p, v_p = -X @ phi, -V[:, :, f:] @ phi - X @ phi_d
        x = np.concatenate([Z, np.zeros_like(Z), none], axis=2)
        v = np.concatenate([V[:, :, :f], Z, none], axis=2)
        u_d = np.concatenate([(V - turning)[:, ind, :f], v[:, ind, f:]], axis=2)
        u_p = v_p[:, ind] + turning[:, ind, f:] @ phi
        rate = np.concatenate(
            [np.concatenate([u_d, u_p], axis=2), free, every[:, n + 3 * n_c :]], axis=1
        )
        m = 2 * f + n_a
        kept = np.concatenate([ind, n + ind, 2 * n + np.arange(n_a)])
        return Linear(rate[:, :, :m], rate[:, :, m:], x, x_p, v, v_p, kept, f)

    def _jacobian_rates(self, t: Array, y: Array, rows: IntArray, Phi_q: Array) -> Array:
        """Return the rates of rows of Phi_q at k states, of which these are the values."""
        model, n = self.model, self.model.n_vel
        v = y[:, model.n_pos : model.n_pos + n]
        step = STEP / np.maximum(np.abs(v * self._units).max(axis=1, initial=0.0), SLOW)
        change = np.zeros((t.size, 2 * n + model.n_aux))
        change[:, :n] = step[:, None] * v
        later = masses_and_jacobians(model, t + step, displaced(model, y, change))[1]
        return np.asarray((later[:, rows] - Phi_q) / step[:, None, None])

    def _steps(self, rates: Array, directions: Array) -> Array:
        """Return the steps (k, d) of differences along directions (k, d, 2 n_vel + n_aux)."""
        n = self.model.n_vel
        sizes = np.abs(directions)
        sizes[:, :, :n] *= self._units
        quick = np.maximum(np.abs(rates * self._units).max(axis=1, initial=0.0), 1.0)
        sizes[:, :, n : 2 * n] *= (self._units / quick[:, None])[:, None]
        largest = sizes.max(axis=2, initial=0.0)
        return np.where(largest > 0.0, STEP / np.maximum(largest, 1e-300), 1.0)


def partition(Phi_q: Array, rank: int) -> tuple[IntArray, IntArray, IntArray]:
    """Return independent rows of Phi_q (n_c, n_vel), scaled, coordinates that they determine, and
    the independent coordinates.

    Raises
    ------
    InputError
        Rows depend on each other: a singular position.
    """
    n = Phi_q.shape[1]
    if rank == 0:
        none = np.zeros(0, dtype=np.int64)
        return none, none, np.arange(n)
    rows = np.sort(qr(Phi_q.T, pivoting=True, mode="r")[1][:rank])
    order = qr(Phi_q[rows], pivoting=True, mode="r")[1]
    return rows, np.sort(order[:rank]), np.sort(order[rank:])


class Partials:
    """Derivatives of the terms by all parameters at known states.

    Stiffness and damping of modes enter by their own derivatives, other numbers of the model by
    models with these numbers a little moved along their independent changes: one for each of these,
    two for `FEW`.

    Attributes
    ----------
    changes : whether the parameters change anything
    """

    def __init__(self, model: Model, columns: Sequence[Column], *, stops: bool = False) -> None:
        self._model, self._count, now = model, len(columns), _arrays(model)
        self._near: list[tuple[Model | None, Model, float]] = []
        P = self._count
        stiffness = [np.zeros((2 * m, P, m)) for m in model.n_mode]  # of modal forces, by q and q'
        every = list[dict[str, Array]]()
        for p, (minus, plus, h) in enumerate(columns):
            one, two = _arrays(minus), _arrays(plus)
            changed = [name for name in one if not np.array_equal(one[name], two[name])]
            rates = {name: 0.5 * (two[name] - one[name]) for name in changed}  # by h
            for which, name in enumerate(("K_qq", "D_qq")):
                if name in rates:
                    rate = rates.pop(name) / h
                    for i, m in enumerate(model.n_mode):
                        stiffness[i][which * m : (which + 1) * m, p] = modal_matrix(
                            model, rate, i
                        ).T
            every.append(rates)
        own = [p for p, change in enumerate(every) if change]
        changes, shares = [every[p] for p in own], np.eye(P)[own]
        if len(own) > FEW:
            kept, among = independent(now, changes, SAME)
            changes, shares = [changes[k] for k in kept], among @ shares
        self._shares = (shares / np.array([column.h for column in columns])).T
        for rates in changes:
            moved = [(n, rate) for n, rate in rates.items() if rate.any()]
            sizes = [np.abs(now[n]).max() / np.abs(rate).max() for n, rate in moved]
            limits = stops and not rates.keys().isdisjoint(model.quantities.programs._fields)
            share = BOTH if len(changes) <= FEW and not limits else STEP
            step = share * float(min((s for s in sizes if s > 0.0), default=1.0 / share))
            low = _moved(model, rates, -step) if stops or len(changes) <= FEW else None
            self._near.append((low, _moved(model, rates, step), step))
        self._stiffness = [(i, K) for i, K in enumerate(stiffness) if K.any()]
        self.changes = bool(self._near or self._stiffness)

    def __call__(self, t: Array, y: Array, a: Array, multipliers: Array, base: Array) -> Array:
        """Return (k, P, w) for P parameters; base (k, w) are the terms at the states."""
        values = np.zeros((t.size, self._count, base.shape[1]))
        if self._near:
            values += self._shares @ np.stack(
                [*self._of_models(t, y, a, multipliers, base)], axis=1
            )
        for j, K, modal in self._modal(y):
            m = K.shape[2]
            change = modal @ K.reshape(2 * m, -1)
            values[:, :, j : j + m] -= change.reshape(t.size, self._count, m)
        return values

    @property
    def rows(self) -> IntArray | None:
        """Which terms change, if only modal forces do; else None: any may."""
        if self._near:
            return None
        model = self._model
        own = [model.vel_start[i] + 6 + np.arange(K.shape[2]) for i, K in self._stiffness]
        return np.concatenate([np.zeros(0, dtype=np.int64), *own])

    def summed(
        self, t: Array, y: Array, a: Array, multipliers: Array, base: Array, weights: Array
    ) -> Array:
        """Return sums (P, v) of the derivatives over states and terms, with weights.

        Parameters
        ----------
        t, y, a, multipliers : (k,) [s], (k, n), (k, n_vel), (k, n_c) the states
        base : (k, w) the terms there
        weights : (k, w, v) of the terms in v numbers
        """
        sums = np.zeros((self._count, weights.shape[2]))
        for shares, partial in zip(
            self._shares.T, self._of_models(t, y, a, multipliers, base), strict=True
        ):
            sums += np.outer(shares, np.tensordot(partial, weights))
        for j, K, modal in self._modal(y):
            both = np.tensordot(modal, weights[:, j : j + K.shape[2]], axes=(0, 0))
            sums -= np.tensordot(K, both, axes=((0, 2), (0, 1)))
        return sums

    def _of_models(
        self, t: Array, y: Array, a: Array, multipliers: Array, base: Array
    ) -> Iterator[Array]:
        at = t, y, a, multipliers
        for low, high, step in self._near:
            less, span = (base, step) if low is None else (terms(low, *at), 2.0 * step)
            yield (terms(high, *at) - less) / span

    def _modal(self, y: Array) -> Iterator[tuple[int, Array, Array]]:
        """Yield for bodies whose modal forces change: where these are, changes, motion (k, 2 m)."""
        for i, K in self._stiffness:
            m, j = K.shape[2], int(self._model.vel_start[i]) + 6
            q, v = int(self._model.pos_start[i]) + 7, self._model.n_pos + j
            yield j, K, np.concatenate([y[:, q : q + m], y[:, v : v + m]], axis=1)


def _arrays(model: Model) -> dict[str, Array]:
    """Return all numbers of a model and of what its expressions read, by name."""
    parts = (model, model.quantities, model.quantities.programs)
    return {
        name: np.asarray(value)
        for part in parts
        for name, value in part._asdict().items()
        if name not in ("layout", "quantities", "programs", "rotor", "stack")
    }


def _moved(model: Model, rates: dict[str, Array], by: float) -> Model:
    """Return a model whose numbers are moved by times their rates, by the names of `_arrays`."""

    def added(part: Any) -> Any:
        new = {}
        for name in rates.keys() & set(part._fields):
            old, change = getattr(part, name), by * rates[name]
            new[name] = old + (change if isinstance(old, np.ndarray) else float(change))
        return part._replace(**new)

    quantities = added(model.quantities)
    return added(model)._replace(
        quantities=quantities._replace(programs=added(quantities.programs))
    )
