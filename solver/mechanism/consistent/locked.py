"""Mechanisms that their joints lock: drives that cannot move, nearly movable closed loops."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...dynamics.analysis.scales import extent
from ...dynamics.elements.constraints.minimum_norm import RANK_TOLERANCE
from ...dynamics.elements.constraints.treatment import row_masses, scaled_jacobian
from ...dynamics.elements.joints.table import DRIVES, NAMES, ROWS
from ...dynamics.evaluation.dense_equations import assemble
from ...dynamics.evaluation.series import balance, driven_speeds
from ...dynamics.model.coordinates import moved
from ...dynamics.model.model import Model
from ...errors import InputError, few
from ...math.arrays import Array


def rows_of(model: Model, joint: int) -> slice:
    """Return the rows of a joint."""
    return slice(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))


def described_gaps(
    model: Model, residual: Array, names: list[str], words: tuple[str, str], least: float = 1e-9
) -> str:
    """List the joints with residuals above `least`, largest first."""
    parts = []
    for k, name in enumerate(names):
        r = residual[rows_of(model, k)]
        units = ROWS[NAMES[model.joint_kind[k]]]
        distance = np.array([unit == "d" for unit in units])
        shift, turn = float(np.linalg.norm(r[distance])), float(np.linalg.norm(r[~distance]))
        if max(shift, turn) > least:
            parts.append(
                (max(shift, turn), f"{name}: {shift:.4g} {words[0]}, {turn:.4g} {words[1]}")
            )
    return few((text for _, text in sorted(parts, reverse=True)), "; ")


WEAK = 3e-3  # singular value over the largest, below which a loop is nearly movable
APART = 20.0  # the next singular value over the weak ones, at least
TURN = 0.1  # of the motion that is tried [rad, over the size]
STAYS = 3.0  # gap of that motion over that of the first order; larger in a singular position
MOTIONS = 12  # free ones that are tried
ITERATIONS, CONVERGED = 20, 1e-12
SLOW = 1e-12  # speed of a drive that stands still [m/s, rad/s]


@dataclass(frozen=True)
class _Joints:
    """Rows of joints, without those of drives, in one state."""

    kept: NDArray[np.bool_]  # (n_c,)
    scale: Array  # (n_vel,) of inertia, all bodies with the same mass: geometry alone counts
    s: Array  # singular values of the scaled Jacobian, over the largest
    Vt: Array  # (n_vel, n_vel) right singular vectors as rows

    @property
    def rank(self) -> int:
        return int(np.sum(self.s > RANK_TOLERANCE))


def require_movable(model: Model, y: Array, names: list[str], times: Array) -> None:
    """Refuse a mechanism whose joints lock it by little, or lock what drives should move.

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
    weak = joints.s[: joints.rank] < WEAK
    if weak.any():
        strong = float(joints.s[: joints.rank][~weak].min(initial=1.0))
        if strong > APART * float(joints.s[: joints.rank][weak].max()):
            _require_singular(model, y, names, float(times[0]), joints, strong)
    if joints.rank == model.n_vel:
        speeds = np.abs(driven_speeds(model, times, y)).max(axis=0, initial=0.0)
        moving = [
            name
            for k, name in enumerate(names)
            if speeds[model.joint_row[k] : model.joint_row[k + 1]].max(initial=0.0) > SLOW
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
    cut = strong / APART**0.5
    gaps = []
    for sign in (1.0, -1.0):
        step = sign * _tried(model, y, joints, joints.Vt[joints.rank - 1])
        near, C, opened = _closed(model, y, t, joints, step, cut)
        first_order = float(np.linalg.norm(C, 2) * np.linalg.norm(step * np.sqrt(joints.scale)))
        if float(np.linalg.norm(opened)) > STAYS * sigma * first_order:
            return
        gaps.append(np.where(joints.kept, balance(model, np.array([t]), near[None]).Phi[0], 0.0))
    free = joints.Vt[joints.rank :]
    for motion in [np.cos(np.arange(1.0, len(free) + 1.0)) @ free, *free[:MOTIONS]]:
        for sign in (1.0, -1.0):
            if not motion.any():
                continue
            step = sign * _tried(model, y, joints, motion)
            s = np.linalg.svd(_closed(model, y, t, joints, step, cut)[1], compute_uv=False)
            if not sigma / STAYS < s[joints.rank - 1] / s[0] < STAYS * sigma:
                return
    gap = max(gaps, key=lambda each: float(np.abs(each).max()))
    least = 0.05 * float(np.abs(gap).max())
    found = described_gaps(model, gap, names, ("m apart", "rad twisted"), least)
    raise InputError(
        "the mechanism is locked by a small misalignment: a motion of "
        f"{TURN:g} rad would open its joints by no more than {found}. Rigid loops need "
        "hinges that are exactly parallel, or meet in one point: give axes and positions with all "
        "digits. If the misalignment is meant, use flexible bodies, joints that leave more freedom "
        "(universal, spherical, cylindrical), or a bushing in place of a joint"
    )


def _tried(model: Model, y: Array, joints: _Joints, motion: Array) -> Array:
    """Return the displacement along a scaled motion (n_vel,) that turns or moves a body by TURN."""
    step = motion / np.sqrt(joints.scale)
    frames = step[np.asarray(model.vel_start)[:, None] + np.arange(6)]
    largest = float(np.max(np.abs(frames) / np.repeat([extent(model, y), 1.0], 3)))
    return np.asarray(step * (TURN / max(largest, 1e-300)))


def _closed(
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
        if np.abs(change).max() < CONVERGED * np.abs(step).max():
            break
    return near, C, D * Phi
