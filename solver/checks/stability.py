"""Watch a run for flexible bodies that lose their stiffness: by spin, or by buckling.

For the geometric stiffness the accelerations of a state are held while a body bends a little
further. What its elastic forces then gain beside K q is the geometric stiffness: of its own
inertia loads and weight (Z0, Z1, G3), and of the forces and moments at its markers (H).
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dynamics.analysis.rank import free_motions
from ..dynamics.analysis.recovery import extent, sizes_of_motion, stiffened
from ..dynamics.elements.floating_frame import stiffening_matrices
from ..dynamics.elements.joints.table import RIGID
from ..dynamics.evaluation import series
from ..dynamics.evaluation.accelerations import assemble
from ..dynamics.evaluation.variations import along_directions
from ..dynamics.model.model import GROUND, Model, modal_matrix
from ..integrators.generic.base import Dense
from ..integrators.generic.drive import Steps, StopRequest
from ..math.arrays import Array, IntArray
from ..math.rotations import rotation_matrices, skew
from ..results.codes import BUCKLING, BUCKLING_LOAD, MATTERS, SPIN, Finding
from .tolerances import (
    DIFFERENCE_STEP,
    LOSS_FOUND,
    ONE_DIRECTION,
    SAME_SPIN,
    SAME_TIME,
    SLOW_GROWTH,
)


class _Inertia(NamedTuple):
    """Modal tables of a body, with the masses that move with its interfaces."""

    M: Array  # (m, m)
    K: Array  # (m, m)
    T11: Array  # (3, 3, m, m)

    def lost(self, w: Array) -> Array:
        """Return what spins w (..., 3) take of the stiffness of a linear body, (..., m, m).

        w_a w_b sum m (delta_ab phi_i.phi_j - phi_ia phi_jb)
        """
        square = (w * w).sum(axis=-1)[..., None, None] * np.einsum("aaij->ij", self.T11)
        return np.asarray(square - np.einsum("...a,...b,abij->...ij", w, w, self.T11))


def _inertias(model: Model) -> dict[int, _Inertia]:
    """Return the tables of the flexible bodies.

    Rigid bodies fixed at their interfaces move with them, heavy point masses are such bodies
    (mechanism/build.py); the tables of the model have the others.
    """
    inertias = {}
    for i in np.flatnonzero(model.n_mode).tolist():
        m, two = int(model.n_mode[i]), int(model.square_start[i])
        M, K = (modal_matrix(model, of, i).copy() for of in (model.M_qq, model.K_qq))
        T11 = model.T11[9 * two : 9 * (two + m * m)].reshape(3, 3, m, m)
        inertias[i] = _Inertia(M, K, 0.5 * (T11 + T11.transpose(1, 0, 3, 2)))
    for joint in np.flatnonzero(np.isin(model.joint_kind, RIGID)):
        pair = model.joint_marker[joint].tolist()
        for marker, other in (pair, pair[::-1]):
            i, fixed = int(model.marker_body[marker]), int(model.marker_body[other])
            if fixed != GROUND and model.n_mode[fixed] == 0 and i in inertias:
                s, m = int(model.marker_start[marker]), int(model.n_mode[i])
                phi, mass = model.marker_phi[s : s + 3 * m].reshape(3, m), float(model.mass[fixed])
                inertias[i].M[:] += mass * phi.T @ phi
                inertias[i].T11[:] += mass * np.einsum("aj,bi->abij", phi, phi)
    return inertias


@dataclass(eq=False, repr=False)
class SpinMonitor:
    """Find the instant when spinning takes away the last stiffness of a linear body.

    Criterion, for every flexible body: the smallest eigenvalue of
    K_ij - w_a w_b sum m (delta_ab phi_i.phi_j - phi_ia phi_jb), masses carried
    at its interfaces included once, is positive. Bodies with geometric stiffening are left out.

    A shaft above its critical speed has lost that stiffness, too, and runs on: gyroscopic forces
    hold it (`holds`).
    """

    model: Model
    body_names: list[str]
    stop: bool = True
    findings: list[Finding] = field(default_factory=list)  # one for each invalid body
    # (body, t (k,), y (k, n)) -> geometric stiffness (k, m, m); None: of a body without its data
    loads: Callable[[int, Array, Array], Array | None] | None = None

    def __post_init__(self) -> None:
        # A stiffened body does not lose its stiffness by spinning: see indicators.py.
        stiffened = np.diff(self.model.second_start) > 0
        self._flexible = [
            i for i in range(self.model.n_body) if self.model.n_mode[i] > 0 and not stiffened[i]
        ]
        self._tables = _inertias(self.model)
        self._held: dict[tuple[int, float, bytes], bool] = {}
        # Below this spin the margin is positive about any axis: no eigenvalues needed there. About
        # three orthogonal axes the lost stiffness adds up to twice the whole w^2 (phi.phi).
        self.safe_spin = {
            i: self._critical(i, np.einsum("aaij->ij", self._tables[i].T11)) for i in self._flexible
        }

    def _critical(self, body: int, lost: Array) -> float:
        """Spin at which the margin vanishes, if unit spin takes `lost` (m, m); inf if never."""
        inverse = np.linalg.inv(np.linalg.cholesky(self._tables[body].K))
        largest = float(np.linalg.eigvalsh(inverse @ lost @ inverse.T)[-1])
        return 1.0 / np.sqrt(largest) if largest > 0 else np.inf

    def spin(self, body: int, y: Array) -> Array:
        """Angular velocity (..., 3) of the body's frame in y (..., n), body components [rad/s]."""
        j = self.model.n_pos + int(self.model.vel_start[body])
        return y[..., j + 3 : j + 6]

    def matrices(self, body: int, y: Array) -> tuple[Array, Array]:
        """Modal stiffness (m, m), and what spins of y (..., n) take of it, (..., m, m) [1/s2]."""
        tables = self._tables[body]
        return tables.K, tables.lost(self.spin(body, y))

    def margin(self, body: int, y: Array, t: float = 0.0) -> float:
        """Smallest eigenvalue of the softened modal stiffness [1/s2].

        Its size where the loss does not count (`holds`).

        Parameters
        ----------
        body : number of the body
        y : state (n,), as in dynamics/model/model.py
        t : time [s]
        """
        K, lost = self.matrices(body, y)
        least = float(np.linalg.eigvalsh(K - lost)[0])
        return least if least > 0.0 or not self._holds(body, t, y) else -least

    def _holds(self, body: int, t: float, y: Array) -> bool:
        """Return whether a body that has lost its stiffness by a state's spin keeps its shape."""
        w, (K, lost) = self.spin(body, y), self.matrices(body, y)
        if self.holds(body, w, K - lost):
            return True
        Kg = self.loads(body, np.array([t]), y[None]) if self.loads else None
        return Kg is not None and self.holds(body, w, K - lost, Kg[0])

    def holds(self, body: int, w: Array, whole: Array, Kg: Array | None = None) -> bool:
        """Return whether a body without stiffness in some directions keeps its shape.

        In a frame that turns at w, M q" + G q' + whole q = 0 with G_ij = 2 sum m phi_i.(w x phi_j)
        in these directions. A round shaft is stable above its critical speed, a blade, whose
        second direction is stiff, is not. A shaft of two stiffnesses grows between its two critical
        speeds, at no more than half their difference. Growth up to SLOW_GROWTH is accepted.

        Where loads neither stiffen nor soften these directions, the loss is the motion's own: no
        term of second order is missing.

        Parameters
        ----------
        w : (3,) spin of the frame, body axes [rad/s]
        whole : (m, m) stiffness of all terms
        Kg : (m, m) geometric stiffness; None: not looked at
        """
        tables = self._tables[body]
        try:
            to_unit = np.linalg.inv(np.linalg.cholesky(tables.M))
        except np.linalg.LinAlgError:  # modes without inertia of their own
            return False
        # In coordinates of unit mass; V: the directions without stiffness.
        gyroscopic = 2.0 * np.einsum("ab,abij->ji", skew(w), tables.T11)
        G, K, whole = (to_unit @ each @ to_unit.T for each in (gyroscopic, tables.K, whole))
        values, V = np.linalg.eigh(whole)
        V = V[:, values <= 0.0]
        if not V.size:
            return True
        if Kg is not None:
            loads = to_unit @ Kg @ to_unit.T
            share = np.abs(np.linalg.eigvalsh(V.T @ loads @ V)).max()
            if share <= MATTERS.limit * np.linalg.eigvalsh(V.T @ K @ V)[0]:
                return True
        # These directions, and those in which gyroscopic forces of their motion push.
        spin = float(np.linalg.norm(w))
        U, s, _ = np.linalg.svd(np.hstack([V, G @ V / (spin or 1.0)]), full_matrices=False)
        B = U[:, s > ONE_DIRECTION * s[0]]
        n = B.shape[1]
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-B.T @ whole @ B, -B.T @ G @ B]])
        return float(np.linalg.eigvals(A).real.max()) <= SLOW_GROWTH * spin

    def critical_spin(self, body: int, direction: Array) -> float:
        """Spin about `direction` (3,) at which the margin vanishes [rad/s]; inf if never."""
        return self._critical(body, self._tables[body].lost(direction / np.linalg.norm(direction)))

    def check(self, y: Array) -> list[int]:
        """Return the bodies that are invalid in state y."""
        return [i for i in self._flexible if self.margin(i, y) <= 0.0]

    def _found(self, body: int, t: float, y: Array) -> Finding:
        w = self.spin(body, y)
        name = self.body_names[body]
        critical, feedback = self.critical_spin(body, w), ""
        if (self.model.quantities.period > 0.0).any():
            feedback = (
                "; if a sampled controller moves it, compare with a shorter sample_time: its "
            )
            feedback += "loop may be unstable"
        text = (
            f"{name}: at t = {t:.4f} s the spin of {np.linalg.norm(w):.4g} rad/s reaches the first "
            "natural frequency of the body in its frame, with the masses that it carries "
            f"({critical:.4g} rad/s). A linear body has no stiffness at this speed: results after "
            "this time are invalid. Set geometric_stiffening = true, use a stiffer or shorter "
            f"body, or reduce the speed{feedback}. "
            'on_invalid = "warn" continues the run'
        )
        spin = float(np.linalg.norm(w))
        self.findings.append(SPIN.finding(text, body=name, t=t, value=spin))
        return self.findings[-1]

    def at_start(self, t: float, y: Array) -> Finding | None:
        """Check the start; return what is found if the run should not begin."""
        findings = [self._found(i, t, y) for i in self.check(y)]
        return findings[0] if findings and self.stop else None

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Check the steps just taken; called by `integrate`."""
        first = {}  # body -> step in which it becomes invalid
        invalid = {finding.body for finding in self.findings}
        for i in self._flexible:
            if self.body_names[i] not in invalid:
                step = self._first_invalid(i, steps)
                if step is not None:
                    first[i] = step
        request = None
        for i, step in sorted(first.items(), key=lambda entry: entry[1]):
            if self.stop and step > min(first.values()):
                break
            dense = steps.dense_output(step)
            begin, end = float(steps.t[step]), float(steps.t[step + 1])

            def margin(t: float, i: int = i, dense: Dense = dense) -> float:
                return self.margin(i, dense(t), t)

            t = _crossing(margin, begin, end, LOSS_FOUND * max(1.0, abs(end)))
            doubt = self._found(i, t, dense(t))
            if self.stop and (request is None or t < request.t_stop):
                request = StopRequest(t, doubt.text, doubt.code)
        return request

    def _first_invalid(self, body: int, steps: Steps) -> int | None:
        """Return the first step at whose end a body is invalid; None if there is none."""
        j = self.model.n_pos + int(self.model.vel_start[body])
        w = steps.y[1:, j + 3 : j + 6]
        doubtful = np.flatnonzero(np.einsum("ka,ka->k", w, w) >= self.safe_spin[body] ** 2)
        if doubtful.size == 0:
            return None
        w, K = w[doubtful], self._tables[body].K
        lost = self._tables[body].lost(w)
        for k in np.flatnonzero(np.linalg.eigvalsh(K - lost)[:, 0] <= 0.0):
            # One look for all states of nearly the same spin; `whole`: its size by powers of two.
            whole = float(np.exp2(np.floor(np.log2(np.abs(w[k]).max()))))
            key = body, whole, np.round(w[k] / (SAME_SPIN * whole)).tobytes()
            if key not in self._held:
                self._held[key] = self.holds(body, w[k], K - lost[k])
            end = doubtful[k] + 1
            if not (self._held[key] or self._holds(body, steps.t[end], steps.y[end])):
                return int(doubtful[k])
        return None


def _crossing(margin: Callable[[float], float], low: float, high: float, near: float) -> float:
    """Bisect for the time at which a margin passes zero, to `near` [s]."""
    while high - low > near:
        middle = 0.5 * (low + high)
        if margin(middle) > 0.0:
            low = middle
        else:
            high = middle
    return high


STATES = 8  # groups of states whose rates and loads are kept


@dataclass(eq=False, repr=False)
class Loading:
    """Rates dy/dt (k, n) and marker loads (k, n_load, 6) of states, kept for all bodies.

    They are those of the whole mechanism: solved again for each of its bodies, the cost of a look
    would be the square of the number of bodies.
    """

    model: Model
    _kept: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)

    def __call__(
        self, t: Array, y: Array, along: tuple[Array, Array] | None = None
    ) -> tuple[Array, Array]:
        """Return rates and loads at times t (k,) and states y (k, n) of one run.

        `along`: rates and multipliers, if they are known.
        """
        key = t.tobytes()
        loads = self._kept.pop(key, None)
        if loads is None:
            rates, multipliers = along or series.along_solution(self.model, t, y)
            loads = rates, series.marker_loads(self.model, t, y, multipliers)
        self._kept[key] = loads  # the last used is last
        if len(self._kept) > STATES:
            self._kept.pop(next(iter(self._kept)))
        return loads


def geometric_stiffness(
    model: Model,
    tables: Model,
    i: int,
    t: Array,
    y: Array,
    loaded: tuple[Array, Array] | None = None,
) -> Array:
    """Return the geometric stiffness (k, m, m) of body i at times t (k,) and states y (k, n) [N m].

    `tables` is a model of the same mechanism whose body i is of second order; accelerations and
    joint forces are those of `model`; `loaded` as `Loading` returns them, if they are known.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    tables : model of the same mechanism whose body i is of second order
    i : number of the body
    t : times (k,) [s]
    y : states (k, n)
    loaded : rates and loads of these states, as `Loading` returns them
    """
    m, a, j = int(model.n_mode[i]), int(model.pos_start[i]), int(model.vel_start[i])
    rates, loads = loaded or Loading(model)(t, y)
    v_d = rates[:, model.n_pos + j :]
    A = rotation_matrices(y[:, a + 3 : a + 7])
    w = y[:, model.n_pos + j + 3 : model.n_pos + j + 6]
    pull = np.einsum("kba,kb->ka", A, v_d[:, :3] - model.gravity_G)
    Kg = stiffening_matrices(tables, i, w, v_d[:, 3:6], pull, v_d[:, 6 : 6 + m])
    markers = series.loaded_markers(model)
    starts = tables.marker_second[markers]
    for place in np.flatnonzero((model.marker_body[markers] == i) & (starts >= 0)).tolist():
        H = tables.marker_H[starts[place] : starts[place] + 6 * m * m].reshape(6, m * m)
        load_B = (loads[:, place].reshape(-1, 2, 3) @ A).reshape(-1, 6)
        Kg = Kg - (load_B @ H).reshape(Kg.shape)
    return np.asarray(0.5 * (Kg + Kg.transpose(0, 2, 1)))


def elastic_motions(model: Model, t: float, y: Array) -> tuple[Array, Array, Array, Array]:
    """Return elastic motions that the joints leave free, and their matrices in state y (n,).

    The motions Z are columns (n_vel, m), the matrices Z'MZ, and of their stiffness and the forces
    of their velocities (m, m). Accelerations and multipliers are held; motions without strain, such
    as those of a pendulum, are left out: those that are looked at have no momentum along them.

    Parameters
    ----------
    model : the mechanism with the second-order terms of its bodies
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    n = model.n_vel
    equations = assemble(model, t, y)
    free = free_motions(equations, model.inertia_scale)
    starts = model.vel_start[np.repeat(np.arange(model.n_body), model.n_mode)] + 6
    elastic = starts + np.concatenate([np.arange(m) for m in model.n_mode])
    weighted = free.Z[elastic] * np.sqrt(model.inertia_scale[elastic])[:, None]
    _, s, Vt = np.linalg.svd(weighted)
    count = int(np.count_nonzero(s > ONE_DIRECTION))
    rigid, bent = free.Z @ Vt[count:].T, free.Z @ Vt[:count].T
    MR = equations.M @ rigid
    bent = bent - rigid @ np.linalg.solve(rigid.T @ MR, MR.T @ bent)
    rates, multipliers = series.along_solution(model, np.array([t]), y[None])
    directions = np.zeros((1, 2 * count, 2 * n + model.n_aux))
    directions[0, :count, :n] = directions[0, count:, n : 2 * n] = bent.T
    sizes = sizes_of_motion(model, extent(model, y))
    step = np.tile(DIFFERENCE_STEP / np.abs(bent / sizes[:, None]).max(axis=0), 2)[None]
    a = rates[:, model.n_pos : model.n_pos + n]
    at = (model, np.array([t]), y[None], a, multipliers, directions)
    change = 0.5 * (along_directions(*at, step) + along_directions(*at, -step))
    forces = -bent.T @ change[0, :, :n].T
    return bent, bent.T @ equations.M @ bent, forces[:, :count], forces[:, count:]


def joints_hold(model: Model, t: float, y: Array) -> bool:
    """Return whether all elastic motions that the joints leave free have stiffness in state y (n,).

    A body without stiffness in its own frame may be held elsewhere: a column between two hinges
    with its frame clamped at one of them would buckle at a quarter of its load.

    Parameters
    ----------
    model : as of `elastic_motions`, as the others
    t : time [s]
    y : state (n,)
    """
    _, _, K, _ = elastic_motions(model, t, y)
    return K.size > 0 and float(np.linalg.eigvalsh(K + K.T)[0]) > 0.0


LOOKS = 1000  # of a run, and one of each block of steps
# Velocity coordinates up to which each look takes the whole mechanism: 5 ms, by their square above.
WHOLE = 100
# Over the lowest frequency of the body [rad]: it does not notice a load that passes sooner, as the
# waves of stress that follow a sudden release.
LASTS = 0.05


def buckling_text(name: str, t: float, *, linear: bool = False) -> str:
    """Return the message for a body, stiffened by default, that buckles at t [s].

    Parameters
    ----------
    name : name of the body
    t : time [s]
    linear : the body has no second-order terms
    """
    beyond, remedy = "Second-order displacements are accurate up to this load only", "Split"
    if linear:
        beyond = "A linear body keeps its full stiffness"
        remedy = "Set geometric_stiffening = true, split"
    return (
        f"{name}: at t = {t:.6g} s the loads of the motion and of the joints reach the buckling "
        f"load of the body. {beyond}: results after this time are invalid. {remedy} the body, "
        "stiffen it, or reduce the load"
    )


@dataclass(eq=False, repr=False)
class BucklingMonitor:
    """Find when elastic and geometric stiffness together lose an eigenvalue.

    A stiffened body buckles then, and second-order displacements do not follow it far: the run
    ends, if asked to. A linear body keeps its stiffness, which is wrong from then on.

    A load that passes sooner than the body can follow is none that it buckles under.

    Parameters
    ----------
    tables : the same mechanism with the second-order terms of all bodies that have them
    bodies : these bodies
    t_end : of the run [s]
    """

    model: Model
    tables: Model
    bodies: Sequence[int]
    spin: SpinMonitor
    t_end: float
    stop: bool = True
    findings: list[Finding] = field(default_factory=list)  # one for each body
    _last: int = -1  # part of the run in which the last look was
    _since: dict[int, float] = field(default_factory=dict)  # start of a loss that lasts so far [s]
    _held: list[float] = field(default_factory=list)  # when joints held all bodies [s], ascending
    _loading: Loading = field(init=False)

    def __post_init__(self) -> None:
        self._loading = Loading(self.model)
        self.spin.loads = self._stiffness_of_loads
        self._lasts = {}  # how long a loss must last to count [s]
        for i in self.bodies:
            lowest = np.linalg.eigvalsh(modal_matrix(self.model, self.model.K_qq, i))[:1]
            self._lasts[i] = LASTS / float(lowest[0]) ** 0.5 if (lowest > 0.0).any() else 0.0

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Check the steps just taken; called by `integrate`."""
        part = np.floor(steps.t[1:] * (LOOKS / self.t_end)).astype(int)
        looks = 1 + np.flatnonzero(np.diff(part, prepend=self._last) > 0)
        self._last = int(part[-1]) if part.size else self._last
        request, known = None, {finding.body for finding in self.findings}
        for i in self.bodies:
            if self.spin.body_names[i] in known:
                continue
            t = self._lost(i, steps, looks)
            if t is None:
                continue
            doubt = self._found(i, t)
            ends = self.stop and stiffened(self.model, i)
            if ends and (request is None or t < request.t_stop):
                request = StopRequest(t, doubt.text, doubt.code)
        return request

    def margin(self, i: int, t: Array, y: Array) -> Array:
        """Smallest eigenvalue of the stiffness of body i in states y (k, n), (k,) [1/s2].

        Its size where the spin alone has taken it and the body keeps its shape (`holds`), and where
        joints hold the body.

        Parameters
        ----------
        i : number of the body
        t : times (k,) [s]
        y : states (k, n)
        """
        elastic = np.subtract(*self.spin.matrices(i, y))
        loads = geometric_stiffness(self.model, self.tables, i, t, y, self._loading(t, y))
        whole = elastic + loads
        lowest = np.full(t.size, np.nan)
        finite = np.isfinite(whole).all(axis=(1, 2))
        lowest[finite] = np.linalg.eigvalsh(whole[finite])[:, 0]
        for k in np.flatnonzero(lowest <= 0.0):
            # A critical speed is no load: it is passed if the loads alone leave stiffness.
            w = self.spin.spin(i, y[k])
            loaded = np.linalg.eigvalsh(self.spin.matrices(i, y[k])[0] + loads[k])[0]
            passed = loaded > 0.0 and self.spin.holds(i, w, whole[k], loads[k])
            if passed or self._joints_hold(float(t[k]), y[k]):
                lowest[k] = -lowest[k]
        return lowest

    def _joints_hold(self, t: float, y: Array) -> bool:
        """Return whether joints hold all bodies in a state, or did in one shortly before it.

        One answer serves all bodies, and in a large mechanism the looks that follow, too, so that
        a run of any size has the cost of `LOOKS` at `WHOLE` coordinates.
        """
        pause = self.t_end / LOOKS * max((self.model.n_vel / WHOLE) ** 2 - 1.0, 0.0)
        k = bisect_right(self._held, t)
        if k == 0 or t - self._held[k - 1] > pause:
            if not joints_hold(self.tables, t, y):
                return False
            self._held.insert(k, t)
        return True

    def _stiffness_of_loads(self, i: int, t: Array, y: Array) -> Array | None:
        if i not in self.bodies:
            return None
        return geometric_stiffness(self.model, self.tables, i, t, y, self._loading(t, y))

    def _lost(self, i: int, steps: Steps, looks: IntArray) -> float | None:
        """Return the time at which body i has been without stiffness long enough [s]."""
        first = 1  # end of a step that is not looked at yet
        while True:
            if i not in self._since:
                ahead = looks[looks >= first]
                lost = self._without(i, steps, ahead)
                if not lost.any():
                    return None
                k = int(np.argmax(lost))
                ends = np.arange(int(ahead[k - 1]) + 1 if k > 0 else first, int(ahead[k]) + 1)
                first = int(ends[np.argmax(self._without(i, steps, ends))])
                dense, begin = steps.dense_output(first - 1), float(steps.t[first - 1])

                def margin(t: float, dense: Dense = dense) -> float:
                    when = np.array([t])
                    return float(self.margin(i, when, dense(when))[0])

                near = SAME_TIME * self.t_end
                self._since[i] = _crossing(margin, begin, float(steps.t[first]), near)
            until = self._since[i] + self._lasts[i]
            last = min(int(np.searchsorted(steps.t, until)), len(steps))
            ends = np.arange(first, last + 1)
            back = ~self._without(i, steps, ends)
            if not back.any():
                return until if steps.t[last] >= until else None
            del self._since[i]
            first = int(ends[np.argmax(back)]) + 1

    def _without(self, i: int, steps: Steps, ends: IntArray) -> NDArray[np.bool_]:
        """Return at which ends of steps (k,) body i has no stiffness left, (k,)."""
        if not ends.size:
            return np.zeros(0, dtype=bool)
        return ~(self.margin(i, steps.t[ends], steps.y[ends]) > 0.0)

    def _found(self, i: int, t: float) -> Finding:
        """Keep and return what was found at t [s]."""
        name, linear = self.spin.body_names[i], not stiffened(self.model, i)
        code = BUCKLING_LOAD if linear else BUCKLING
        text = buckling_text(name, t, linear=linear)
        self.findings.append(code.finding(text, body=name, t=t))
        return self.findings[-1]
