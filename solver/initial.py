"""Consistent start: positions that assemble, velocities and accelerations that fit."""

from dataclasses import dataclass

import numpy as np

from .bodies.marker import marker_motion
from .errors import InputError
from .joints.table import KINDS, NAMES, ROWS
from .model import Model
from .package.schema import Array
from .rotations import parameter_rate
from .system import Equations, assemble, law_at

_POSITION_TOLERANCE = 1e-12
_VELOCITY_TOLERANCE = 1e-9
_MAX_STEP = 0.5  # [m, rad] of one Newton correction: a rough start must not jump
_MAX_ITERATIONS = 60

ROTATION = KINDS["rotation_drive"]


@dataclass(frozen=True)
class Start:
    """Rough positions and given velocities, in the order of the model's coordinates."""

    positions: Array  # (n_pos,)
    velocities: Array  # (n_vel,): values where given
    given: Array  # (n_vel,) bool: True where the velocity is given and must be kept


def consistent_state(model: Model, start: Start, joint_names: list[str], t: float = 0.0) -> Array:
    """Return the state y (n,) at time t that satisfies position and velocity constraints.

    Raises
    ------
    InputError
        Mechanism that cannot be assembled, redundant constraints, or given
        velocities that contradict joints and drives; names the joints.
    """
    y = np.concatenate([start.positions, np.zeros(model.n_vel + 1)])
    if model.n_constraint:
        y = _assembled(model, y, joint_names, t)
        _check_rank(model, assemble(model, t, y), joint_names)
    y[model.n_pos : model.n_pos + model.n_vel] = _velocities(model, start, y, joint_names, t)
    return y


def _rows(model: Model, joint: int) -> slice:
    return slice(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))


def _describe(model: Model, residual: Array, names: list[str], words: tuple[str, str]) -> str:
    """Say which joints leave a residual, worst first."""
    parts = []
    for k, name in enumerate(names):
        r = residual[_rows(model, k)]
        units = ROWS[NAMES[model.joint_kind[k]]]
        distance = np.array([unit == "d" for unit in units])
        shift, turn = float(np.linalg.norm(r[distance])), float(np.linalg.norm(r[~distance]))
        if max(shift, turn) > 1e-9:
            parts.append(
                (max(shift, turn), f"{name}: {shift:.4g} {words[0]}, {turn:.4g} {words[1]}")
            )
    return "; ".join(text for _, text in sorted(parts, reverse=True))


def _assembled(model: Model, y: Array, names: list[str], t: float) -> Array:
    """Close the joints by the least change of frame positions and orientations."""
    elastic = np.zeros(model.n_vel, dtype=bool)
    for i in range(model.n_body):
        j = int(model.vel_start[i])
        elastic[j + 6 : j + 6 + int(model.n_mode[i])] = True
    y = y.copy()
    for _ in range(_MAX_ITERATIONS):
        equations = assemble(model, t, y)
        if np.max(np.abs(equations.Phi)) < _POSITION_TOLERANCE:
            break
        J = equations.Phi_q[:, ~elastic]
        step = np.zeros(model.n_vel)
        step[~elastic] = np.linalg.lstsq(J, -equations.Phi, rcond=1e-10)[0]
        step *= min(1.0, _MAX_STEP / max(np.max(np.abs(step)), 1e-300))
        for i in range(model.n_body):
            a, j = int(model.pos_start[i]), int(model.vel_start[i])
            y[a : a + 3] += step[j : j + 3]
            p = y[a + 3 : a + 7] + parameter_rate(y[a + 3 : a + 7], step[j + 3 : j + 6])
            y[a + 3 : a + 7] = p / np.linalg.norm(p)
    equations = assemble(model, t, y)
    if np.max(np.abs(equations.Phi)) > 1e3 * _POSITION_TOLERANCE:
        apart = _describe(model, equations.Phi, names, ("m apart", "rad twisted"))
        raise InputError(
            "the mechanism cannot be assembled from the given positions; joints left open: "
            f"{apart}. "
            "Check lengths, ground points and initial positions of the bodies"
        )
    for k, name in enumerate(names):
        if model.joint_kind[k] == ROTATION and _drive_cosine(model, y, k, t) < 0:
            raise InputError(
                f"the drive of {name} assembles half a turn away from its value at the start; "
                "give initial positions nearer to it"
            )
    return y


def _drive_cosine(model: Model, y: Array, joint: int, t: float) -> float:
    """Return cos(angle - f(t)) of a rotation drive: +1 on the wanted branch, -1 opposite."""
    one = marker_motion(model, int(model.joint_marker[joint, 0]), y)
    two = marker_motion(model, int(model.joint_marker[joint, 1]), y)
    f, _, _ = law_at(model, model.joint_law[joint], t)
    wanted = one.A[:, 0] * np.cos(f) + one.A[:, 1] * np.sin(f)
    return float(wanted @ two.A[:, 0])


def _check_rank(model: Model, equations: Equations, names: list[str]) -> None:
    """Refuse redundant or contradictory constraints, naming the joints involved."""
    U, s, _ = np.linalg.svd(equations.Phi_q)
    rank = int(np.sum(s > 1e-10 * s[0])) if s.size else 0
    n_c = model.n_constraint
    if rank == n_c:
        return
    weight = np.abs(U[:, rank:]).max(axis=1)
    involved = [name for k, name in enumerate(names) if weight[_rows(model, k)].max() > 1e-6]
    raise InputError(
        f"joints: {n_c} constraint equations of rank {rank} at the start: "
        f"{n_c - rank} redundant among {', '.join(involved)}; expected independent joints "
        "(replace one by a joint with fewer constraints)"
    )


def _velocities(model: Model, start: Start, y: Array, names: list[str], t: float) -> Array:
    """Keep the given velocities; the others follow from the joints at least kinetic energy."""
    equations = assemble(model, t, y)
    free = ~np.asarray(start.given, dtype=bool)
    v = np.where(free, 0.0, start.velocities)
    n_free, n_c = int(free.sum()), model.n_constraint
    if n_c == 0 and n_free == 0:
        return v
    A = np.zeros((n_free + n_c, n_free + n_c))
    b = np.zeros(n_free + n_c)
    A[:n_free, :n_free] = equations.M[np.ix_(free, free)]
    A[n_free:, :n_free] = equations.Phi_q[:, free]
    A[:n_free, n_free:] = equations.Phi_q[:, free].T
    b[:n_free] = -(equations.M @ v)[free]
    b[n_free:] = -equations.Phi_t - equations.Phi_q @ v
    v[free] = np.linalg.lstsq(A, b, rcond=1e-12)[0][:n_free]
    residual = equations.Phi_q @ v + equations.Phi_t
    scale = max(1.0, float(np.max(np.abs(v), initial=0.0)))
    if n_c and np.max(np.abs(residual)) > _VELOCITY_TOLERANCE * scale:
        off = _describe(model, residual, names, ("m/s", "rad/s"))
        raise InputError(
            f"initial velocities contradict the joints and drives: {off}; "
            "give fewer velocities or values that fit"
        )
    return v
