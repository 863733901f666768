"""The tangent of a motion: the equations of motion linearised along the accepted steps of a run.

With displacements x along the velocity coordinates, changes v of velocities and z of auxiliary
states per unit of each parameter, and D the derivative along (x, v, z) and by the parameter itself,

    Phi_q x + Phi_p = 0,    D Phidot = 0,    x' = v - w x x (rotations, in body axes),
    M v' + Phi_q' lambda' = D(f - M a - Phi_q' lambda),    Phi_q v' = D(gamma - Phi_q a),

at known a and lambda. The constraints make the dependent coordinates follow, so that a tangent is
one of independent coordinates u = x_I, s = v_I and z, by Radau IIA of order 5 on the steps of the
run. It is the derivative of the exact motion, and satisfies the linearised constraints: what steps
and corrections onto the constraints add to the motion has the size of the tolerance. Reasons:
docs/sensitivities.md.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

from ...dynamics.analysis.recovery import extent
from ...dynamics.evaluation.accelerations import derivative, masses_and_jacobians
from ...dynamics.evaluation.evaluation import Instants, beyond, sampled
from ...dynamics.evaluation.series import along_solution, quantities
from ...dynamics.evaluation.variations import along_directions, terms
from ...dynamics.model.coordinates import displaced
from ...dynamics.model.model import Model, modal_matrix
from ...integrators.compiled.radau_stages import A_INVERSE, POWERS, A, C
from ...integrators.generic.drive import Steps
from ...math.arrays import Array, IntArray
from ..linearisation.differences import units_of

# Forward differences: their error, and that of round-off, are near 1e-8 of the largest term.
STEP = 3e-8
BATCH = 2_000_000  # numbers of the terms of one batch of steps
NEAR = 1e-6  # of the size of the mechanism: distance from a bend of a force
SLOW = 1e-6  # sizes of the mechanism per second, or rad/s: below, a state is at rest
MOST_GROWTH = 1e4  # of dependent coordinates over independent ones, by inertia


class Column(NamedTuple):
    """A parameter: the model at its value less and plus h, treated like that of the run."""

    minus: Model
    plus: Model
    h: float


class Batch(NamedTuple):
    """Stages of k steps."""

    t: Array  # (k + 1,) ends [s]
    y: Array  # (3 k, n) states at the stages, with their accelerations and multipliers
    a: Array  # (3 k, n_vel)
    multipliers: Array  # (3 k, n_c)

    @property
    def at(self) -> Array:
        """Times of the stages (3 k,) [s]."""
        return (self.t[:-1, None] + np.diff(self.t)[:, None] * C).ravel()


class Tangent:
    """Carries the derivatives of a state by P parameters along steps.

    Parameters
    ----------
    model : of the run
    columns : the parameters
    y0 : (n,) start
    S : its derivatives
    bends : numbers of coordinates, and values at which a force along them has a bend

    Attributes
    ----------
    S : (2 n_vel + n_aux, P) displacements, changes of velocities and of auxiliary states
    units : (n_vel,) of velocity coordinates as shares of the mechanism's size, or angles
    """

    def __init__(
        self,
        model: Model,
        columns: Sequence[Column],
        y0: Array,
        S: Array,
        bends: Sequence[tuple[int, float]] = (),
    ) -> None:
        self.model, self.columns, self.S, self._bends = model, columns, S, bends
        self._size = extent(model, y0)
        self.units = units_of(model, self._size)
        self._root = np.sqrt(model.inertia_scale)
        n = model.n_vel
        per_step = 3 * (2 * n + 4 * model.n_constraint + 10) * (3 * n + len(columns))
        self._batch = int(np.clip(BATCH // per_step, 1, 500))
        self._partials = [_Partial(model, column) for column in columns]

    @property
    def is_still(self) -> bool:
        """Whether no parameter changes anything: S stays zero."""
        return not self.S.any() and not any(each.changes for each in self._partials)

    def follow(self, steps: Steps, times: Array) -> Array:
        """Carry S over steps without a jump between them.

        Returns S at `times` (m,), behind the beginning and not behind the end of the steps,
        (m, 2 n_vel + n_aux, P).
        """
        found = np.empty((times.size, *self.S.shape))
        t, begin = steps.t, 0
        parts = self._bent(steps)
        while begin < len(steps):
            end = min(begin + self._batch, len(steps), *(i for i in parts if i > begin))
            if begin in parts:
                end = begin + 1
                batch = self._split(steps, begin, parts[begin])
            else:
                batch = self._taken(steps, begin, end)
            own = (times > t[begin]) & (times <= t[end])
            done = self._over(batch, times[own])
            while done is None:  # other independent coordinates sooner
                end = begin + (end - begin + 1) // 2
                own = (times > t[begin]) & (times <= t[end])
                done = self._over(self._taken(steps, begin, end), times[own])
            found[own] = done
            begin = end
        return found

    def _taken(self, steps: Steps, begin: int, end: int) -> Batch:
        """Return the stages of some steps as the run has left them."""
        assert steps.Z is not None
        assert steps.multipliers is not None
        model, Z = self.model, steps.Z[begin:end]
        h, v = np.diff(steps.t[begin : end + 1]), slice(model.n_pos, model.n_pos + model.n_vel)
        stages = (steps.y[begin:end, None] + Z).reshape(-1, Z.shape[2])
        self._normalise(stages)
        rates = np.einsum("ab,kbi->kai", A_INVERSE, Z[:, :, v]) / h[:, None, None]
        multipliers = steps.multipliers[begin:end, :, : model.n_constraint]
        return Batch(
            steps.t[begin : end + 1],
            stages,
            np.ascontiguousarray(rates.reshape(len(stages), -1)),
            np.ascontiguousarray(multipliers.reshape(len(stages), -1)),
        )

    def _split(self, steps: Steps, i: int, parts: Array) -> Batch:
        """Return step i in parts that end at bends, parts (k, 2) of it, from its polynomial.

        Derivatives at the end of a part are those a bit earlier, on this side of the bend.
        """
        model, h = self.model, steps.t[i + 1] - steps.t[i]
        begins = np.concatenate([[0.0], parts[:-1, 0]])
        length = parts[:, 0] - begins
        x = begins[:, None] + length[:, None] * C
        x[:, 2] -= np.clip(parts[:, 1], 1e-4 * length, 0.1 * length)
        t, y = steps.t[i] + x.ravel() * h, self._within(steps, i, x.ravel())
        self._normalise(y)
        rates, multipliers = along_solution(model, t, y)
        a = rates[:, model.n_pos : model.n_pos + model.n_vel]
        ends = np.concatenate([begins, [1.0]])
        return Batch(steps.t[i] + ends * h, y, np.ascontiguousarray(a), multipliers)

    def _normalise(self, y: Array) -> None:
        """Give the Euler parameters of states y (k, n) length one, in place."""
        for a in self.model.pos_start:
            p = y[:, a + 3 : a + 7]
            p /= np.sqrt((p * p).sum(axis=1, keepdims=True))

    def _within(self, steps: Steps, i: int, x: Array) -> Array:
        """Return states at the parts x (k,) of step i."""
        assert steps.Z is not None
        return np.asarray(steps.y[i] + x[:, None] ** np.arange(1, 4) @ POWERS @ steps.Z[i])

    def _bent(self, steps: Steps) -> dict[int, Array]:
        """Return the steps with bends of forces along coordinates, and where: see `_split`."""
        found: dict[int, list[tuple[float, float]]] = {}
        if not self._bends:
            return {}
        near = NEAR * self._size
        values = quantities(self.model, steps.t, steps.y)
        for number, level in self._bends:
            gap, h = values[:, 2 * number] - level, np.diff(steps.t)
            early = near / np.maximum(np.abs(values[1:, 2 * number + 1]) * h, 1e-300)
            at_end = np.abs(gap) < near
            crossing = (gap[1:] * gap[:-1] < 0.0) & ~at_end[1:] & ~at_end[:-1]
            for i in np.flatnonzero(crossing | at_end[1:]).tolist():
                x = np.array([1.0])
                if crossing[i]:
                    x = self._passage(steps, i, number, level, float(gap[i]))
                found.setdefault(i, []).append((float(x[0]), float(early[i])))
        return {
            i: np.array(sorted({x: e for x, e in [*parts, (1.0, 0.0), *parts]}.items()))
            for i, parts in found.items()
        }

    def _passage(self, steps: Steps, i: int, number: int, level: float, before: float) -> Array:
        """Return the part of step i at which a coordinate passes a level, (1,)."""
        x = np.linspace(0.0, 1.0, 65)
        for _ in range(4):
            t = np.full(x.size, steps.t[i])
            there = quantities(self.model, t, self._within(steps, i, x))[:, 2 * number]
            passed = (there - level) * before <= 0.0
            k = max(int(passed.argmax()), 1) if passed.any() else x.size - 1
            x = np.linspace(x[k - 1], x[k], 65)
        return x[:1]

    def _over(self, batch: Batch, times: Array) -> Array | None:
        """Carry S over a batch; return it at times (m,), or None where no partition holds."""
        t, h = batch.t, np.diff(batch.t)
        k = h.size
        linear = self._linear(batch.at, *batch[1:], last=k <= 2)
        if linear is None:
            return None
        w = self._stages(linear, h)
        x, v = linear.x @ w + linear.x_p, linear.v @ w + linear.v_p
        S = np.concatenate([x, v, w[:, 2 * linear.n_free :]], axis=1).reshape(k, 3, *self.S.shape)
        S_old = np.concatenate([self.S[None], S[:-1, 2]])
        self.S = S[-1, 2]
        i = np.clip(np.searchsorted(t, times) - 1, 0, k - 1)
        powers = ((times - t[i]) / h[i])[:, None] ** np.arange(1, 4) @ POWERS
        return np.asarray(S_old[i] + np.einsum("tk,tkip->tip", powers, S[i] - S_old[i, None]))

    def jump(self, t: float, before: Array, after: Array, event: int) -> None:
        """Carry S over an instant at which auxiliary states take other values.

        The state is `before` (n,) and `after` it. `event` >= 0: the instant is that of an event,
        which moves with the parameters by dt = -D gap / rate: S+ = D(before + rate dt) - rate+ dt.
        """
        model, n = self.model, self.model.n_vel
        first = model.n_pos + n
        which = Instants(model, t + 1.0).sampled_at(t)
        if event >= 0:
            which[model.quantities.event_state[event]] = True
        rates = [
            np.concatenate([y[model.n_pos : first], derivative(model, t, y)[model.n_pos : -1]])
            for y in (before, after)
        ]
        for p, column in enumerate(self.columns):
            h, late = column.h, 0.0
            sides = ((column.minus, -h), (column.plus, h))
            if event >= 0:
                gaps = [
                    beyond(m, t, displaced(model, before, s * self.S[:, p]))[event]
                    for m, s in sides
                ]
                late = -(gaps[1][0] - gaps[0][0]) / (gaps[1][1] + gaps[0][1]) / h
            S = self.S[:, p] + late * rates[0]
            low, high = (
                sampled(m, t + s * late, displaced(model, before, s * S), which)[first:-1]
                for m, s in sides
            )
            S[2 * n :] = np.where(which, (high - low) / (2.0 * h), S[2 * n :])
            self.S[:, p] = S - late * rates[1]

    def _stages(self, linear: "Linear", h: Array) -> Array:
        """Return the independent coordinates at the stages of steps h (k,), (3 k, m, P)."""
        k, m, columns = h.size, linear.J.shape[1], linear.g.shape[2]
        J, g = linear.J.reshape(k, 3, m, m), linear.g.reshape(k, 3, m, columns)
        hA = h[:, None, None] * A
        matrix = np.eye(3 * m) - np.einsum("kab,kbij->kaibj", hA, J).reshape(k, 3 * m, 3 * m)
        load = np.einsum("kab,kbip->kaip", hA, g).reshape(k, 3 * m, columns)
        start = np.broadcast_to(np.tile(np.eye(m), (3, 1)), (k, 3 * m, m))
        answer = np.linalg.solve(matrix, np.concatenate([start, load], axis=2))
        w, last = np.empty_like(load), self.S[linear.kept]
        for i in range(k):
            w[i] = answer[i, :, :m] @ last + answer[i, :, m:]
            last = w[i, 2 * m :]
        return w.reshape(3 * k, m, columns)

    def _linear(
        self, t: Array, y: Array, a: Array, multipliers: Array, *, last: bool
    ) -> "Linear | None":
        """Return the equations of the independent coordinates at k states; see `_over`.

        Parameters
        ----------
        a, multipliers : (k, n_vel), (k, n_c)
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
        partial = np.empty((t.size, len(self.columns), n + 3 * n_c + n_a))
        for p, each in enumerate(self._partials):
            each(t, y, a, multipliers, base, partial[:, p])
        # The rows that parameters move: their dependent motions X, at positions and velocities.
        phi, phi_d = (partial[:, :, n + which * n_c + rows].transpose(0, 2, 1) for which in (1, 2))
        own = np.flatnonzero(phi.any(axis=(0, 2)) | phi_d.any(axis=(0, 2)))
        phi, phi_d = phi[:, own], phi_d[:, own]
        X = np.zeros((t.size, n, own.size))
        X[:, dep] = inverse[:, :, own]
        of_phi, of_phi_d = X, X
        if own.size > len(self.columns):
            of_phi, of_phi_d = X @ phi, X @ phi_d
            phi = phi_d = np.broadcast_to(np.eye(len(self.columns)), (t.size, *[phi.shape[2]] * 2))
        G = np.concatenate([Z, of_phi], axis=2)
        # Body axes turn: -w x rotations is part of the rate of a displacement.
        rates, turning = y[:, model.n_pos : model.n_pos + n], np.zeros_like(G)
        for j in model.vel_start:
            w, turn = rates[:, j + 3 : j + 6, None], G[:, j + 3 : j + 6]
            for c in range(3):
                one, two = (c + 1) % 3, (c + 2) % 3
                turning[:, j + 3 + c] = w[:, one] * turn[:, two] - w[:, two] * turn[:, one]
        # D Phidot along displacements: d(Phi_q x)/dt at constant x, less Phi_q of the turning.
        V = np.zeros_like(G)
        V[:, dep] = inverse @ (Phi_q @ turning - self._jacobian_rates(t, y, rows, Phi_q) @ G)
        d, none = G.shape[2], np.zeros((t.size, n, n_a))
        directions = np.zeros((t.size, 2 * d + n_a, 2 * n + n_a))
        directions[:, :d, :n], directions[:, :d, n : 2 * n] = (
            part.transpose(0, 2, 1) for part in (G, V)
        )
        directions[:, d : d + f, n : 2 * n] = Z.transpose(0, 2, 1)
        directions[:, d + f : 2 * d, n : 2 * n] = of_phi_d.transpose(0, 2, 1)
        directions[:, 2 * d :, 2 * n :] = np.eye(n_a)
        along = along_directions(
            model, t, y, a, multipliers, directions, self._steps(rates, directions)
        )
        phi_t, phi_d_t = (each.transpose(0, 2, 1) for each in (phi, phi_d))
        partial -= phi_t @ along[:, f:d] + phi_d_t @ along[:, d + f : 2 * d]
        every = np.concatenate(
            [along[:, :f], along[:, d : d + f], along[:, 2 * d :], partial], axis=1
        ).transpose(0, 2, 1)
        Z_M = Z.transpose(0, 2, 1) @ M
        # What the rows ask of dependent accelerations is taken from the loads.
        left = Z.transpose(0, 2, 1) @ every[:, :n] - (Z_M[:, :, dep] @ inverse) @ every[:, n + rows]
        free = np.linalg.solve(Z_M @ Z, left)
        x_p, v_p = -of_phi @ phi, -V[:, :, f:] @ phi - of_phi_d @ phi_d
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
        step = STEP / np.maximum(np.abs(v * self.units).max(axis=1, initial=0.0), SLOW)
        change = np.zeros((t.size, 2 * n + model.n_aux))
        change[:, :n] = step[:, None] * v
        later = masses_and_jacobians(model, t + step, displaced(model, y, change))[1]
        return np.asarray((later[:, rows] - Phi_q) / step[:, None, None])

    def _steps(self, rates: Array, directions: Array) -> Array:
        """Return the steps (k, d) of differences along directions (k, d, 2 n_vel + n_aux)."""
        n = self.model.n_vel
        sizes = np.abs(directions)
        sizes[:, :, :n] *= self.units
        quick = np.maximum(np.abs(rates * self.units).max(axis=1, initial=0.0), 1.0)
        sizes[:, :, n : 2 * n] *= (self.units / quick[:, None])[:, None]
        largest = sizes.max(axis=2, initial=0.0)
        return np.where(largest > 0.0, STEP / np.maximum(largest, 1e-300), 1.0)


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


class _Partial:
    """Derivative of the terms by a parameter at known states.

    Stiffness and damping of modes enter by their own derivatives, other numbers of the model by a
    model with these numbers a little moved along theirs.

    Attributes
    ----------
    changes : whether the parameter changes anything
    """

    def __init__(self, model: Model, column: Column) -> None:
        one, two = _arrays(column.minus), _arrays(column.plus)
        rates = {
            name: (two[name] - one[name]) / (2.0 * column.h)
            for name in one
            if not np.array_equal(one[name], two[name])
        }
        self.changes = bool(rates)
        self._matrices: list[tuple[int, int, Array, Array]] = []
        K, D = (rates.pop(name, np.zeros(model.K_qq.size)) for name in ("K_qq", "D_qq"))
        for i in range(model.n_body) if K.any() or D.any() else ():
            at = int(model.pos_start[i]) + 7, model.n_pos + int(model.vel_start[i]) + 6
            self._matrices.append((*at, modal_matrix(model, K, i), modal_matrix(model, D, i)))
        now = _arrays(model)
        sizes = [np.abs(now[n]).max() / np.abs(rate).max() for n, rate in rates.items()]
        self._h = STEP * float(min((s for s in sizes if s > 0.0), default=column.h / STEP))
        self._near = _moved(model, {name: self._h * rate for name, rate in rates.items()})
        self._n_pos, self._is_near = model.n_pos, bool(rates)

    def __call__(
        self, t: Array, y: Array, a: Array, multipliers: Array, base: Array, out: Array
    ) -> None:
        """Fill out (k, w); base (k, w) are the terms at the states."""
        out[:] = 0.0
        if self._is_near:
            out[:] = (terms(self._near, t, y, a, multipliers) - base) / self._h
        for q, v, K, D in self._matrices:
            m, j = len(K), v - self._n_pos
            out[:, j : j + m] -= y[:, q : q + m] @ K.T + y[:, v : v + m] @ D.T


def _arrays(model: Model) -> dict[str, Array]:
    """Return all numbers of a model and of what its expressions read, by name."""
    parts = (model, model.quantities, model.quantities.programs)
    return {
        name: np.asarray(value)
        for part in parts
        for name, value in part._asdict().items()
        if name not in ("plan", "quantities", "programs", "rotor", "stack")
    }


def _moved(model: Model, changes: dict[str, Array]) -> Model:
    """Return a model with other numbers: by how much, by the names of `_arrays`."""

    def added(part: Any) -> Any:
        own = {name: getattr(part, name) for name in changes.keys() & set(part._fields)}
        return part._replace(
            **{
                name: old + (changes[name] if isinstance(old, np.ndarray) else float(changes[name]))
                for name, old in own.items()
            }
        )

    quantities = added(model.quantities)
    return added(model)._replace(
        quantities=quantities._replace(programs=added(quantities.programs))
    )
