"""Consistent start: assembled positions, and velocities that satisfy the constraints."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...dynamics.analysis.projection import least_energy
from ...dynamics.analysis.rank import clearly_independent
from ...dynamics.analysis.scales import SAMPLES, extent
from ...dynamics.elements.bodies.marker import marker_motion
from ...dynamics.elements.constraints.minimum_norm import RANK_TOLERANCE
from ...dynamics.elements.constraints.treatment import scaled_jacobian
from ...dynamics.elements.joints.table import DRIVES, NAMES
from ...dynamics.evaluation.dense_equations import Equations, accelerations, assemble
from ...dynamics.evaluation.events import started
from ...dynamics.evaluation.laws import law_at
from ...dynamics.evaluation.series import balance
from ...dynamics.model.coordinates import moved
from ...dynamics.model.model import Model
from ...errors import InputError, few
from ...math.arrays import Array
from ...results.codes import REDUNDANT, SINGULAR_START, Finding
from .locked import described_gaps, require_movable, rows_of

_POSITION_TOLERANCE = 1e-12
_VELOCITY_TOLERANCE = 1e-9
SPRUNG = 1e-5  # gap [rad, over the size] that tilted hinges leave, closed by deformation
PREFERRED = 1e3  # of motion of frames over deformation, which counts as sqrt(J)
GIVEN = "Check lengths, ground points and initial positions of the bodies"
DEFORMED = (
    "They close while the bodies are undeformed: give bodies that twist as they bend modes of "
    "torsion and of bending in both planes, or take joints that leave more freedom (spherical, "
    "universal, point_on_line)"
)
ALL = slice(None)
_MAX_STEP = 0.5  # [m, rad] limit of one Newton correction, for rough initial positions
_MAX_ITERATIONS = 60


@dataclass(frozen=True)
class Start:
    """Approximate positions and given velocities, in the order of the model's coordinates."""

    positions: Array  # (n_pos,)
    velocities: Array  # (n_vel,): values where given
    given: Array  # (n_vel,) bool: True for given velocities, which must be kept


@dataclass(frozen=True)
class Redundancy:
    """Redundant constraint equations."""

    count: int
    joints: list[str]  # joints that share them
    singular_start: bool  # the rank at the start is lower than in general

    @property
    def independent(self) -> bool:
        """Whether no equation depends on others at the start."""
        return self.count == 0 and not self.singular_start

    def findings(self) -> list[Finding]:
        """Return what a user should know of it."""
        found = []
        if self.count:
            text = (
                f"{self.count} constraint equations follow from the others, among "
                f"{few(self.joints)}: the motion is not affected, but how these joints share "
                "their forces is not determined; the share of least norm is reported. Joints that "
                "leave more freedom (spherical, universal, cylindrical) remove the doubt"
            )
            found.append(REDUNDANT.finding(text, t=0.0, value=float(self.count)))
        if self.singular_start:
            text = (
                "the mechanism starts in a singular position, where it could move in more "
                "directions than elsewhere: give velocities that say which"
            )
            found.append(SINGULAR_START.finding(text, t=0.0))
        return found


def consistent_state(
    model: Model,
    start: Start,
    joint_names: list[str],
    t: float = 0.0,
    *,
    deforming: bool = False,
) -> Array:
    """Return the state y (n,) at time t that satisfies position and velocity constraints.

    `deforming`: bodies may deform, and have modal rates, where frames alone do not close the
    joints; otherwise only to close the small gaps of tilted hinges.

    Raises
    ------
    InputError
        The mechanism cannot be assembled, or given velocities contradict joints and
        drives; names the joints.
    """
    y = np.concatenate([start.positions, np.zeros(model.n_vel), model.quantities.start, [0.0]])
    if model.n_constraint:
        y = _assembled(model, y, joint_names, t, deforming=deforming)
    v = _velocities(model, start, y, joint_names, t, deforming=deforming)
    y[model.n_pos : model.n_pos + model.n_vel] = v
    return started(model, t, y)


def closed_by_frames(model: Model, y: Array, rows: NDArray[np.bool_], t: float = 0.0) -> Array:
    """Return y (n,) after the least change of frames that closes some rows (n_c,) of the joints."""
    return _closed(model, y, t, rows=rows)


def _closed(
    model: Model,
    y: Array,
    t: float,
    *,
    elastic: bool = False,
    rows: "NDArray[np.bool_] | slice" = ALL,
) -> Array:
    """Return y after Newton's steps of least change of frame positions and orientations.

    elastic : bodies deform where frames alone do not close the joints, with least strain energy
    rows : of the joints that are to be closed
    """
    scale, y = _ease(model, elastic=elastic), y.copy()
    for _ in range(_MAX_ITERATIONS):
        if _open(model, y, t)[rows].max(initial=0.0) < _POSITION_TOLERANCE:
            break  # without the dense Jacobian of a long chain
        equations = assemble(model, t, y)
        J, gap = equations.Phi_q[rows], equations.Phi[rows]
        step = scale * np.linalg.lstsq(J * scale, -gap, rcond=1e-10)[0]
        step *= min(1.0, _MAX_STEP / max(np.max(np.abs(step)), 1e-300))
        y[: model.n_pos] = moved(model, y[: model.n_pos], step)
    return y


def _ease(model: Model, *, elastic: bool) -> Array:
    """Return how easily each coordinate changes to close joints, (n_vel,)."""
    scale = np.full(model.n_vel, PREFERRED if elastic else 1.0)
    for i in range(model.n_body):
        j, m, k = int(model.vel_start[i]) + 6, int(model.n_mode[i]), int(model.square_start[i])
        stiffness = np.diagonal(model.K_qq[k : k + m * m].reshape(m, m))
        scale[j : j + m] = 1.0 / np.sqrt(np.maximum(stiffness, 1.0)) if elastic else 0.0
    return scale


def undeformed(model: Model, y: Array, t: float) -> Array:
    """Return state y (n,) with bodies without deformation, joints closed."""
    y = y.copy()
    for i in range(model.n_body):
        a = int(model.pos_start[i]) + 7
        y[a : a + int(model.n_mode[i])] = 0.0
    return _closed(model, y, t)


def frames_close(model: Model, y: Array, t: float = 0.0) -> bool:
    """Tell whether the joints can be closed in state y (n,) without further deformation."""
    if not model.n_constraint:
        return True
    return bool(_open(model, _closed(model, y, t), t).max() <= 1e3 * _POSITION_TOLERANCE)


def _open(model: Model, y: Array, t: float) -> Array:
    """Return |Phi|, (n_c,), in state y."""
    return np.abs(balance(model, np.array([t]), y[None]).Phi[0])


def _assembled(model: Model, y: Array, names: list[str], t: float, *, deforming: bool) -> Array:
    """Close the joints; the error names those that stay open."""
    y = _closed(model, y, t)
    gap, sprung = _open(model, y, t), np.inf if deforming else SPRUNG
    if 1e3 * _POSITION_TOLERANCE < gap.max() < sprung * min(1.0, extent(model, y)):
        y = _closed(model, y, t, elastic=True)
        gap = _open(model, y, t)
    if gap.max() > 1e3 * _POSITION_TOLERANCE:
        apart = described_gaps(model, gap, names, ("m apart", "rad twisted"))
        raise InputError(
            "the mechanism cannot be assembled from the given positions; joints left open: "
            f"{apart}. {DEFORMED if deforming else GIVEN}"
        )
    for k, name in enumerate(names):
        if _at_another_root(model, y, k, t):
            raise InputError(
                f"the drive of {name} assembles half a turn away from its value at the start; "
                "give initial positions closer to it"
            )
    return y


def _at_another_root(model: Model, y: Array, joint: int, t: float) -> bool:
    """Tell whether the rows of a drive hold, but not its coordinate."""
    drive = DRIVES.get(NAMES[model.joint_kind[joint]])
    if drive is None or drive.side is None:
        return False
    one, two = (marker_motion(model, int(k), y) for k in model.joint_marker[joint])
    f, _, _ = law_at(model, model.joint_law[joint], t)
    return drive.side(one.A, two.A, f) < 0.0


def redundancy(
    model: Model, y: Array, names: list[str], t: float = 0.0, t_end: float | None = None
) -> Redundancy:
    """Count the redundant constraint equations at a consistent state y.

    The rank is computed at the start and at a position close to it. In a singular starting position
    the rank is lower than in general. Drives are looked at until `t_end`; None: at t.

    Raises
    ------
    InputError
        Joints and drives contradict each other, or lock the mechanism (locked.py); names them.
    """
    if model.n_constraint == 0 or clearly_independent(model, y, t):
        return Redundancy(0, [], False)
    require_movable(model, y, names, np.linspace(t, t if t_end is None else t_end, SAMPLES))
    equations = assemble(model, t, y)
    here = _Rank(equations, model.inertia_scale, RANK_TOLERANCE)
    general = here
    if here.value < model.n_constraint and here.value < model.n_vel:
        near = _nearby(model, y, here, t)
        if near is not None:
            # larger tolerance: this state satisfies the joints less accurately than the start
            found = _Rank(assemble(model, t, near), model.inertia_scale, 1e3 * RANK_TOLERANCE)
            general = found if found.value > here.value else here
    count = model.n_constraint - general.value
    if count == 0:
        return Redundancy(0, [], general.value > here.value)
    involved = _involved(model, general, names)
    state = accelerations(model._replace(redundant=count), equations, y)[0]
    residual = equations.Phi_q @ state - equations.gamma
    terms = np.abs(equations.Phi_q) @ np.abs(state)  # whose rounding is in the residual
    size = max(1.0, float(np.max(np.abs(equations.gamma))), float(np.max(terms)))
    if np.max(np.abs(residual)) > _VELOCITY_TOLERANCE * size:
        off = described_gaps(model, residual, names, ("m/s2", "rad/s2"))
        raise InputError(
            f"joints and drives contradict each other in their accelerations: {off}; "
            f"{count} of {model.n_constraint} constraint equations are redundant, among "
            f"{few(involved)}"
        )
    return Redundancy(count, involved, general.value > here.value)


class _Rank:
    """Rank of the scaled Jacobian, and its singular vectors."""

    def __init__(self, equations: Equations, inertia_scale: Array, tolerance: float) -> None:
        self._C = scaled_jacobian(equations.Phi_q, inertia_scale)
        s = np.linalg.svd(self._C, compute_uv=False)
        self.value = int(np.sum(s > tolerance * s[0]))

    @cached_property
    def _vectors(self) -> tuple[Array, Array]:
        # several times the work of the values, and not needed for independent rows
        U, _, Vt = np.linalg.svd(self._C)
        return U[:, self.value :], Vt[self.value :]

    @property
    def left(self) -> Array:
        """Combinations of rows that vanish, as columns."""
        return self._vectors[0]

    @property
    def null(self) -> Array:
        """Motions that the rows leave free, as rows."""
        return self._vectors[1]


def _involved(model: Model, rank: _Rank, names: list[str]) -> list[str]:
    weight = np.abs(rank.left).max(axis=1, initial=0.0)
    return [name for k, name in enumerate(names) if weight[rows_of(model, k)].max() > 1e-6]


def _nearby(model: Model, y: Array, rank: _Rank, t: float) -> Array | None:
    """Return a state a hundredth of a radian from y that satisfies the joints, or None."""
    mix = np.cos(np.arange(1.0, rank.null.shape[0] + 1.0))  # an arbitrary direction
    step = (mix @ rank.null) / np.sqrt(model.inertia_scale)
    near = y.copy()
    near[: model.n_pos] = moved(model, y[: model.n_pos], 0.01 * step / np.max(np.abs(step)))
    near = _closed(model, near, t)
    closed = _open(model, near, t).max() < 1e3 * _POSITION_TOLERANCE
    return near if closed else None


def _velocities(
    model: Model, start: Start, y: Array, names: list[str], t: float, *, deforming: bool
) -> Array:
    """Keep the given velocities; the others follow from the joints with minimum kinetic energy.

    deforming : bodies deform, at a rate of least strain, where frames alone cannot follow
    """
    free = ~np.asarray(start.given, dtype=bool)
    v = np.where(free, 0.0, start.velocities)
    n_free, n_c = int(free.sum()), model.n_constraint
    if n_c == 0 and n_free == 0:
        return v
    if n_c == 0 or clearly_independent(model, y, t):  # the time is linear in the bodies
        given = np.flatnonzero(~free)
        found = least_energy(model, t, y, given, v[given])
        moving = np.concatenate([y[: model.n_pos], found, [0.0]])
        violation = np.abs(balance(model, np.array([t]), moving[None]).Phi_d).max(initial=0.0)
        if violation < _POSITION_TOLERANCE * max(1.0, float(np.abs(found).max())):
            return found
    equations = assemble(model, t, y)
    v[free] = _least_energy(equations, model, v, free)
    residual = equations.Phi_q @ v + equations.Phi_t
    scale = max(1.0, float(np.max(np.abs(v), initial=0.0)))
    if deforming and n_c:
        ease = _ease(model, elastic=True)
        v = v - ease * np.linalg.lstsq(equations.Phi_q * ease, residual, rcond=1e-10)[0]
        residual = equations.Phi_q @ v + equations.Phi_t
    if n_c and np.max(np.abs(residual)) > _VELOCITY_TOLERANCE * scale:
        require_movable(model, y, names, np.array([t]))
        off = described_gaps(model, residual, names, ("m/s", "rad/s"))
        raise InputError(
            f"initial velocities contradict the joints and drives: {off}; "
            "give fewer velocities or consistent values"
        )
    return v


def _least_energy(equations: Equations, model: Model, v: Array, free: Array) -> Array:
    """Return free velocities of least kinetic energy, for constraints that may be redundant.

    First velocities that satisfy the constraints, in a metric without masses, then what least
    energy adds to them in the null space: a heavy body behind a light one costs no digits of the
    constraints. One system for both would lose as many as the ratio of the masses has.

    Parameters
    ----------
    v : (n_vel,) the given velocities, zero where `free` (n_vel,)
    """
    frame = np.repeat(model.vel_start, np.diff([*model.vel_start, model.n_vel]))
    root = (np.sqrt(model.inertia_scale[frame]) / np.sqrt(model.inertia_scale))[free]
    missing = -equations.Phi_t - equations.Phi_q @ v
    J = equations.Phi_q[:, free] * root
    U, s, Vt = np.linalg.svd(J) if J.size else (np.eye(J.shape[0]), np.zeros(0), np.eye(J.shape[1]))
    rank = int(np.sum(s > RANK_TOLERANCE * s.max(initial=0.0)))
    found = root * (Vt[:rank].T @ ((U[:, :rank].T @ missing) / s[:rank]))
    null = root[:, None] * Vt[rank:].T
    if null.shape[1]:
        # least squares on a root of M: twice the digits of the normal equations
        diagonal = np.diag(equations.M)
        size = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        w, X = np.linalg.eigh(equations.M / size[:, None] / size)
        C = (X * np.sqrt(np.maximum(w, 0.0))).T * (size / size.max())
        still = v.copy()
        still[free] = found
        found = found - null @ np.linalg.lstsq(C[:, free] @ null, C @ still, rcond=None)[0]
    return found
