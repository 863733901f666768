"""Consistent start: assembled positions, and velocities that satisfy the constraints.

Mechanisms that their joints lock are refused: drives that cannot move, nearly movable closed loops.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dynamics.analysis.projection import least_energy
from ..dynamics.analysis.rank import clearly_independent
from ..dynamics.analysis.recovery import SAMPLES, extent, sizes_of_motion
from ..dynamics.elements.constraints.treatment import row_masses, scaled_jacobian
from ..dynamics.elements.joints.table import DRIVES, NAMES, ROWS
from ..dynamics.elements.marker import marker_motion
from ..dynamics.evaluation.accelerations import Equations, accelerations, assemble
from ..dynamics.evaluation.instants import started
from ..dynamics.evaluation.laws import law_at
from ..dynamics.evaluation.series import balance, driven_speeds
from ..dynamics.model.coordinates import moved
from ..dynamics.model.model import Model, modal_matrix
from ..dynamics.tolerances import RANK_TOLERANCE
from ..errors import InputError, few
from ..math.arrays import Array
from ..math.records import record
from ..results.codes import REDUNDANT, SINGULAR_START, Finding
from .built_mechanism import Start
from .tolerances import (
    DRIVE_AT_REST,
    MOTION_CONVERGED,
    NEARLY_MOVABLE,
    POSITION_TOLERANCE,
    STAYS_CLOSED,
    STAYS_OPEN,
    VELOCITY_TOLERANCE,
    WEAK_APART,
)


def rows_of(model: Model, joint: int) -> slice:
    """Return the rows of a joint."""
    return slice(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))


def described_gaps(
    model: Model,
    residual: Array,
    names: list[str],
    labels: tuple[str, str],
    least: float | None = None,
) -> str:
    """List the joints with residuals above `least`, largest first.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    residual : residuals of the constraints (n_c,) [m, rad, or rates]
    names : names of the joints
    labels : words or units for distances and rotations
    least : residual below which a joint is left out; None: the largest times STAYS_OPEN
    """
    parts = []
    if least is None:
        least = STAYS_OPEN * float(np.abs(residual).max(initial=0.0))
    for k, name in enumerate(names):
        r = residual[rows_of(model, k)]
        units = ROWS[NAMES[model.joint_kind[k]]]
        distance = np.array([unit == "d" for unit in units])
        shift, turn = float(np.linalg.norm(r[distance])), float(np.linalg.norm(r[~distance]))
        if max(shift, turn) > least:
            parts.append(
                (max(shift, turn), f"{name}: {shift:.4g} {labels[0]}, {turn:.4g} {labels[1]}")
            )
    return few((text for _, text in sorted(parts, reverse=True)), "; ")


TURN = 0.1  # of the motion that is tried [rad, over the size]
MOTIONS = 12  # free ones that are tried
ITERATIONS = 20


class _Joints(NamedTuple):
    """Rows of joints, without those of drives, in one state."""

    kept: NDArray[np.bool_]  # (n_c,)
    scale: Array  # (n_vel,) of inertia, all bodies with the same mass: geometry alone counts
    s: Array  # singular values of the scaled Jacobian, over the largest
    Vt: Array  # (n_vel, n_vel) right singular vectors as rows

    @property
    def rank(self) -> int:
        return int(np.sum(self.s > RANK_TOLERANCE))


def require_movable(model: Model, y: Array, names: list[str], times: Array) -> None:
    """Refuse a mechanism whose joints nearly lock it, or lock what drives should move.

    Parameters
    ----------
    y : (n,) state at times[0] with closed joints
    names : of the model's joints
    times : (k,) at which drives are looked at [s]

    Raises
    ------
    InputError
        Names the joints, and the drives.
    """
    joints = _decomposed(model, y, float(times[0]))
    if joints is None:
        return
    weak = joints.s[: joints.rank] < NEARLY_MOVABLE
    if weak.any():
        strong = float(joints.s[: joints.rank][~weak].min(initial=1.0))
        if strong > WEAK_APART * float(joints.s[: joints.rank][weak].max()):
            _require_singular(model, y, names, float(times[0]), joints, strong)
    if joints.rank == model.n_vel:
        speeds = np.abs(driven_speeds(model, times, y)).max(axis=0, initial=0.0)
        moving = [
            name
            for k, name in enumerate(names)
            if speeds[model.joint_row[k] : model.joint_row[k + 1]].max(initial=0.0) > DRIVE_AT_REST
        ]
        if moving:
            raise InputError(
                "the mechanism is locked: its joints leave no degree of freedom at t = 0, so that "
                f"nothing can follow {few(moving)}. Use flexible bodies, or joints that leave more "
                "freedom"
            )


def _decomposed(model: Model, y: Array, t: float) -> _Joints | None:
    """Decompose the Jacobian of the joints; None without any."""
    kept = np.ones(model.n_constraint, dtype=bool)
    for joint, kind in enumerate(model.joint_kind):
        if NAMES[kind] in DRIVES:
            kept[int(model.joint_row[joint]) : int(model.joint_row[joint + 1])] = False
    if not kept.any():
        return None
    frame = np.repeat(model.vel_start, np.diff([*model.vel_start, model.n_vel]))
    scale = model.inertia_scale / model.inertia_scale[frame]
    _, s, Vt = np.linalg.svd(scaled_jacobian(assemble(model, t, y).Phi_q[kept], scale))
    return _Joints(kept, scale, s / s[0], Vt)


def _require_singular(
    model: Model, y: Array, names: list[str], t: float, joints: _Joints, strong: float
) -> None:
    """Refuse the weakest motion that joints exclude, unless the gap it opens soon becomes large.

    So it does beside a singular position, along this motion or after one of the free ones.
    """
    sigma = float(joints.s[joints.rank - 1])
    cut = strong / WEAK_APART**0.5
    gaps = []
    for sign in (1.0, -1.0):
        step = sign * _tried(model, y, joints, joints.Vt[joints.rank - 1])
        near, C, opened = _closed_by_least_squares(model, y, t, joints, step, cut)
        first_order = float(np.linalg.norm(C, 2) * np.linalg.norm(step * np.sqrt(joints.scale)))
        if float(np.linalg.norm(opened)) > STAYS_CLOSED * sigma * first_order:
            return
        gaps.append(np.where(joints.kept, balance(model, np.array([t]), near[None]).Phi[0], 0.0))
    free = joints.Vt[joints.rank :]
    for motion in [np.cos(np.arange(1.0, len(free) + 1.0)) @ free, *free[:MOTIONS]]:
        for sign in (1.0, -1.0):
            if not motion.any():
                continue
            step = sign * _tried(model, y, joints, motion)
            s = np.linalg.svd(
                _closed_by_least_squares(model, y, t, joints, step, cut)[1], compute_uv=False
            )
            if not sigma / STAYS_CLOSED < s[joints.rank - 1] / s[0] < STAYS_CLOSED * sigma:
                return
    gap = max(gaps, key=lambda each: float(np.abs(each).max()))
    least = 0.05 * float(np.abs(gap).max())
    listed = described_gaps(model, gap, names, ("m apart", "rad twisted"), least)
    raise InputError(
        "the mechanism is locked by a small misalignment: a motion of "
        f"{TURN:g} rad would open its joints by no more than {listed}. Rigid loops need "
        "hinges that are exactly parallel, or meet in one point: give axes and positions with all "
        "digits. If the misalignment is meant, use flexible bodies, joints that leave more freedom "
        "(universal, spherical, cylindrical), or a bushing in place of a joint"
    )


def _tried(model: Model, y: Array, joints: _Joints, motion: Array) -> Array:
    """Return the displacement along a scaled motion (n_vel,) that turns or moves a body by TURN."""
    step = motion / np.sqrt(joints.scale)
    largest = float(np.max(np.abs(step / sizes_of_motion(model, extent(model, y)))))
    return np.asarray(step * (TURN / max(largest, 1e-300)))


def _closed_by_least_squares(
    model: Model, y: Array, t: float, joints: _Joints, step: Array, cut: float
) -> tuple[Array, Array, Array]:
    """Move by a step, then close the joints as far as singular values above `cut` allow.

    Returns
    -------
    near : (n,) the state there
    C : scaled Jacobian of the joints
    opened : their gaps in its scale
    """
    near, root = y.copy(), 1.0 / np.sqrt(joints.scale)
    near[: model.n_pos] = moved(model, y[: model.n_pos], step)
    for _ in range(ITERATIONS):
        equations = assemble(model, t, near)
        J, Phi = equations.Phi_q[joints.kept], equations.Phi[joints.kept]
        D = np.sqrt(row_masses(J, joints.scale))
        C = D[:, None] * J * root
        change = root * np.linalg.lstsq(C, -D * Phi, rcond=cut)[0]
        near[: model.n_pos] = moved(model, near[: model.n_pos], change)
        if np.abs(change).max() < MOTION_CONVERGED * np.abs(step).max():
            break
    return near, C, D * Phi


SPRUNG = 1e-5  # gap [rad, over the size] that tilted hinges leave, closed by deformation
PREFERRED = 3e4  # of motion of frames over deformation
GIVEN = "Check lengths, ground points and initial positions of the bodies"
DEFORMED = (
    "They close while the bodies are undeformed: give bodies that twist as they bend modes of "
    "torsion and of bending in both planes, or take joints that leave more freedom (spherical, "
    "universal, point_on_line)"
)
_MAX_STEP = 0.5  # limit of one Newton correction, in `sizes_of_motion`, for rough positions
_MAX_ITERATIONS = 60


@record
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
        results = []
        if self.count:
            text = (
                f"{self.count} constraint equations follow from the others, among "
                f"{few(self.joints)}: the motion is not affected, but how these joints share "
                "their forces is not determined; the share of least norm is reported. Joints that "
                "leave more freedom (spherical, universal, cylindrical) remove the doubt"
            )
            results.append(REDUNDANT.finding(text, t=0.0, value=float(self.count)))
        if self.singular_start:
            text = (
                "the mechanism starts in a singular position, where it could move in more "
                "directions than elsewhere: give velocities that say which"
            )
            results.append(SINGULAR_START.finding(text, t=0.0))
        return results


def consistent_state(
    model: Model,
    start: Start,
    joint_names: list[str],
    *,
    deforming: bool = False,
    moved: bool = False,
) -> Array:
    """Return the state y (n,) at the start that satisfies position and velocity constraints.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    start : positions and velocities at the start, as the case gives them
    joint_names : names of the joints of the model, for messages
    deforming : bodies may deform, and have modal rates, where frames alone do not close the joints
    moved : velocities were given for other positions and may change as little as the joints need

    Raises
    ------
    InputError
        The mechanism cannot be assembled, or given velocities contradict joints and
        drives; names the joints.
    """
    y = np.concatenate([start.positions, np.zeros(model.n_vel), model.quantities.start, [0.0]])
    if model.n_constraint:
        y = _assembled(model, y, joint_names, deforming=deforming)
    v = _velocities(model, start, y, joint_names, deforming=deforming or moved)
    y[model.n_pos : model.n_pos + model.n_vel] = v
    return started(model, 0.0, y)


def assembled(model: Model, start: Start, joint_names: list[str]) -> Array:
    """Return positions (n_pos,) that close the joints. Raises InputError if there are none.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    start : positions and velocities at the start, as the case gives them
    joint_names : names of the joints of the model, for messages
    """
    y = np.concatenate([start.positions, np.zeros(model.n_vel), model.quantities.start, [0.0]])
    return _assembled(model, y, joint_names, deforming=False)[: model.n_pos]


def with_closed_joints(model: Model, y: Array, *, elastic: bool = False) -> Array:
    """Return y (n,) after Newton's steps of least change of frames that close the joints at t = 0.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    elastic : bodies deform where frames alone do not close the joints, with least strain energy
    """
    size, y = extent(model, y), y.copy()
    scale, rows = _ease(model, size, elastic=elastic), row_sizes(model, size)[:, None]
    for _ in range(_MAX_ITERATIONS):
        if _open(model, y, size).max(initial=0.0) < POSITION_TOLERANCE:
            break  # without the dense Jacobian of a long chain
        equations = assemble(model, 0.0, y)
        J, gap = equations.Phi_q / rows, equations.Phi / rows[:, 0]
        step = scale * np.linalg.lstsq(J * scale, -gap, rcond=1e-10)[0]
        largest = float(np.max(np.abs(step) / sizes_of_motion(model, size)))
        step *= min(1.0, _MAX_STEP / max(largest, 1e-300))
        y[: model.n_pos] = moved(model, y[: model.n_pos], step)
    return y


def _ease(model: Model, size: float, *, elastic: bool) -> Array:
    """Return how easily each coordinate changes to close joints, (n_vel,).

    A motion by the size [m] of the mechanism counts as a turn by 1 rad, and a deformation by its
    strain energy: the easiest one by the size counts as such a motion as well.
    """
    scale, energy = sizes_of_motion(model, size), np.full(model.n_vel, np.nan)
    for i in range(model.n_body):
        j, m = int(model.vel_start[i]) + 6, int(model.n_mode[i])
        energy[j : j + m] = np.diagonal(modal_matrix(model, model.K_qq, i))
    frames = np.isnan(energy)
    energy *= scale**2
    least = energy[energy > 0.0].min(initial=np.inf)
    deforms = 1.0 / np.sqrt(np.maximum(energy / least, 1.0)) if elastic else 0.0
    return np.asarray(scale * np.where(frames, PREFERRED if elastic else 1.0, deforms))


def undeformed(model: Model, y: Array) -> Array:
    """Return state y (n,) with bodies without deformation, joints closed."""
    y = y.copy()
    for i in range(model.n_body):
        a = int(model.pos_start[i]) + 7
        y[a : a + int(model.n_mode[i])] = 0.0
    return with_closed_joints(model, y)


def frames_close(model: Model, y: Array) -> bool:
    """Return whether the joints can be closed in state y (n,) without further deformation."""
    if not model.n_constraint:
        return True
    return bool(_open(model, with_closed_joints(model, y), extent(model, y)).max() <= STAYS_OPEN)


def row_sizes(model: Model, size: float) -> Array:
    """Return the units of the constraints, (n_c,): the size of the mechanism for distances, or 1.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    size : of the mechanism [m]
    """
    units = (unit for kind in model.joint_kind for unit in ROWS[NAMES[kind]])
    return np.array([size if unit == "d" else 1.0 for unit in units])


def _open(model: Model, y: Array, size: float) -> Array:
    """Return |Phi|, (n_c,), in state y [rad, over the size]."""
    return np.abs(balance(model, np.zeros(1), y[None]).Phi[0]) / row_sizes(model, size)


def _assembled(model: Model, y: Array, names: list[str], *, deforming: bool) -> Array:
    """Close the joints; the error names those that stay open."""
    size, y = extent(model, y), with_closed_joints(model, y)
    gap = _open(model, y, size)
    if STAYS_OPEN < gap.max() < (np.inf if deforming else SPRUNG):
        y = with_closed_joints(model, y, elastic=True)
        gap = _open(model, y, size)
    if gap.max() > STAYS_OPEN:
        gap = gap * row_sizes(model, size)
        apart = described_gaps(model, gap, names, ("m apart", "rad twisted"))
        raise InputError(
            "the mechanism cannot be assembled from the given positions; joints left open: "
            f"{apart}. {DEFORMED if deforming else GIVEN}"
        )
    for k, name in enumerate(names):
        if _at_another_root(model, y, k):
            raise InputError(
                f"the drive of {name} assembles half a turn away from its value at the start; "
                "give initial positions closer to it"
            )
    return y


def _at_another_root(model: Model, y: Array, joint: int) -> bool:
    """Return whether the rows of a drive hold, but not its coordinate."""
    drive = DRIVES.get(NAMES[model.joint_kind[joint]])
    if drive is None or drive.side is None:
        return False
    one, two = (marker_motion(model, int(k), y) for k in model.joint_marker[joint])
    f, _, _ = law_at(model, model.joint_law[joint], 0.0)
    return drive.side(one.A, two.A, f) < 0.0


def redundancy(model: Model, y: Array, names: list[str], t_end: float = 0.0) -> Redundancy:
    """Count the redundant constraint equations at a consistent state y.

    The rank is computed at the start and at a position close to it. In a singular starting position
    the rank is lower than in general. Drives are looked at until `t_end`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    names : names of the joints
    t_end : end of the time over which drives are checked [s]

    Raises
    ------
    InputError
        Joints and drives contradict each other, or lock the mechanism; names them.
    """
    if model.n_constraint == 0 or clearly_independent(model, y):
        return Redundancy(0, [], False)
    require_movable(model, y, names, np.linspace(0.0, t_end, SAMPLES))
    equations = assemble(model, 0.0, y)
    here = _Rank(equations, model.inertia_scale, RANK_TOLERANCE)
    general = here
    if here.value < model.n_constraint and here.value < model.n_vel:
        near = _nearby(model, y, here)
        if near is not None:
            # larger tolerance: this state satisfies the joints less accurately than the start
            nearby = _Rank(assemble(model, 0.0, near), model.inertia_scale, 1e3 * RANK_TOLERANCE)
            general = nearby if nearby.value > here.value else here
    count = model.n_constraint - general.value
    if count == 0:
        return Redundancy(0, [], general.value > here.value)
    weight = np.abs(general.left).max(axis=1, initial=0.0)
    involved = [name for k, name in enumerate(names) if weight[rows_of(model, k)].max() > 1e-6]
    state = accelerations(model._replace(redundant=count), equations, y)[0]
    residual = equations.Phi_q @ state - equations.gamma
    # The residual has the rounding of these.
    terms = np.abs(equations.Phi_q) @ (np.abs(state) + np.abs(equations.f) / model.inertia_scale)
    size = max(1.0, float(np.max(np.abs(equations.gamma))), float(np.max(terms)))
    if np.max(np.abs(residual)) > VELOCITY_TOLERANCE * size:
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


def _nearby(model: Model, y: Array, rank: _Rank) -> Array | None:
    """Return a state a hundredth of a radian from y that satisfies the joints, or None."""
    mix = np.cos(np.arange(1.0, rank.null.shape[0] + 1.0))  # an arbitrary direction
    step, size = (mix @ rank.null) / np.sqrt(model.inertia_scale), extent(model, y)
    near, largest = y.copy(), np.max(np.abs(step) / sizes_of_motion(model, size))
    near[: model.n_pos] = moved(model, y[: model.n_pos], 0.01 * step / largest)
    near = with_closed_joints(model, near)
    closed = _open(model, near, size).max() < STAYS_OPEN
    return near if closed else None


def _velocities(
    model: Model, start: Start, y: Array, names: list[str], *, deforming: bool
) -> Array:
    """Keep the given velocities; the others follow from the joints with minimum kinetic energy.

    deforming : bodies deform, at a rate of least strain, where frames alone cannot follow
    """
    free = ~np.asarray(start.given, dtype=bool)
    v = np.where(free, 0.0, start.velocities)
    n_free, n_c = int(free.sum()), model.n_constraint
    if n_c == 0 and n_free == 0:
        return v
    if n_c == 0 or clearly_independent(model, y):  # the time is linear in the bodies
        given = np.flatnonzero(~free)
        velocity = least_energy(model, 0.0, y, given, v[given])
        moving = y.copy()
        moving[model.n_pos : model.n_pos + model.n_vel] = velocity
        violation = np.abs(balance(model, np.zeros(1), moving[None]).Phi_d).max(initial=0.0)
        if violation < POSITION_TOLERANCE * max(1.0, float(np.abs(velocity).max())):
            return velocity
    equations = assemble(model, 0.0, y)
    v[free] = _least_energy(equations, model, v, free)
    residual = equations.Phi_q @ v + equations.Phi_t
    scale = max(1.0, float(np.max(np.abs(v), initial=0.0)))
    if deforming and n_c:
        ease = _ease(model, extent(model, y), elastic=True)
        v = v - ease * np.linalg.lstsq(equations.Phi_q * ease, residual, rcond=1e-10)[0]
        residual = equations.Phi_q @ v + equations.Phi_t
    if n_c and np.max(np.abs(residual)) > VELOCITY_TOLERANCE * scale:
        require_movable(model, y, names, np.zeros(1))
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
    change = root * (Vt[:rank].T @ ((U[:, :rank].T @ missing) / s[:rank]))
    null = root[:, None] * Vt[rank:].T
    if null.shape[1]:
        # least squares on a root of M: twice the digits of the normal equations
        diagonal = np.diag(equations.M)
        size = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        w, X = np.linalg.eigh(equations.M / size[:, None] / size)
        C = (X * np.sqrt(np.maximum(w, 0.0))).T * (size / size.max())
        still = v.copy()
        still[free] = change
        change = change - null @ np.linalg.lstsq(C[:, free] @ null, C @ still, rcond=None)[0]
    return change
