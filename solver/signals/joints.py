"""Joint coordinates, joint reactions, sizes of forces along coordinates and in couplings."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..dynamics.analysis.recovery import Recording, Values
from ..dynamics.elements.joints.contract import Angle, Displacement, Drive
from ..dynamics.elements.joints.table import CONSTRAINTS, COORDINATES, NAMES
from ..dynamics.evaluation.evaluation import n_coupling
from ..dynamics.evaluation.laws import law_at
from ..dynamics.evaluation.series import force_sizes
from ..dynamics.model.model import ANGLE, SPIN
from ..math.arrays import Array
from ..mechanism.built_mechanism import BuiltJoint, BuiltMechanism

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import ReactionSignal


class _Turned(NamedTuple):
    """An angle at the times of a block, (k,) each."""

    t: Array  # [s]
    found: Array  # within a turn [rad]
    rate: Array  # [rad/s]
    whole: Array  # without jumps [rad]


def joint_coordinate(joint: BuiltJoint, coordinate: str) -> Callable[[Recording], Array]:
    """Return what gives a coordinate (k,) of a joint from its given start [rad or m]."""
    kind = COORDINATES[coordinate]
    if isinstance(kind, Displacement):
        axis = kind.axis
        return lambda recording: _shifts(recording, joint)[:, axis] - joint.shift[axis]
    angle, key = kind, object()

    def angles(recording: Recording) -> Array:
        def compute(before: _Turned | None) -> tuple[Array, _Turned]:
            now = _angles(recording, joint, angle, before)
            return now.whole, now

        return recording.carried(key, compute)

    return angles


def reaction(joint: BuiltJoint, signal: "ReactionSignal") -> Callable[[Recording], Array]:
    """Return what gives the force or moment (k, 3) of a joint and its drives on one side."""

    def vectors(recording: Recording) -> Array:
        both = recording.reactions(joint.rows, signal.side)
        values = both[:, :3] if signal.quantity == "force" else both[:, 3:]
        if signal.axes == "joint":
            one, _ = _ends(recording, joint)
            values = np.einsum("kba,kb->ka", recording.axes(one), values)
        return values

    return vectors


def _ends(recording: Recording, joint: BuiltJoint) -> tuple[int, int]:
    one, two = recording.model.joint_marker[joint.rows[0]]
    return int(one), int(two)


def _shifts(recording: Recording, joint: BuiltJoint) -> Array:
    """Return the vector (k, 3) from place one to two in axes of place one [m]."""
    one, two = _ends(recording, joint)
    arm = recording.position(two) - recording.position(one)
    return np.asarray(np.einsum("kba,kb->ka", recording.axes(one), arm))


def _angles(
    recording: Recording, joint: BuiltJoint, angle: Angle, before: _Turned | None
) -> _Turned:
    """Return an angle with its rate, unwrapped, after that of the block before.

    The number of turns between two output times follows from the rates at both. It is correct if
    their mean gives the rotation to within half a turn.
    """
    one, two = _ends(recording, joint)
    frame, arm = (one, two) if angle.frame == 1 else (two, one)
    angles, rate = _angle(recording, frame, arm, angle)
    t = recording.t
    if before is not None:
        t = np.concatenate([before.t[-1:], t])
        angles = np.concatenate([before.found[-1:], angles])
        rate = np.concatenate([before.rate[-1:], rate])
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(t)
    off = np.diff(angles) - steps
    steps += off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))
    if before is not None:
        return _Turned(t[1:], angles[1:], rate[1:], before.whole[-1] + np.cumsum(steps))
    first = angles[0] + _turns(recording, joint, angle, angles[0])
    return _Turned(t, angles, rate, np.concatenate([[first], first + np.cumsum(steps)]))


def _angle(recording: Recording, frame: int, arm: int, angle: Angle) -> tuple[Array, Array]:
    """Angle (k,) [rad] and rate (k,) [rad/s] of an axis of `arm` from one of `frame` to another."""
    A = recording.axes(frame)
    x, y, a = A[:, :, angle.x], A[:, :, angle.y], recording.axes(arm)[:, :, angle.arm]
    u, v = np.einsum("ka,ka->k", x, a), np.einsum("ka,ka->k", y, a)
    n = u[:, None] * np.cross(a, y) - v[:, None] * np.cross(a, x)
    turning = recording.spin(arm) - recording.spin(frame)
    return np.arctan2(v, u), np.einsum("ka,ka->k", n, turning) / (u * u + v * v)


def _turns(recording: Recording, joint: BuiltJoint, angle: Angle, angle_at: float) -> float:
    """Whole turns [rad] that a drive of the angle starts with."""
    model = recording.model
    for row in joint.rows[1:]:
        drive = CONSTRAINTS[NAMES[model.joint_kind[row]]]
        if isinstance(drive, Drive) and drive.coordinate == angle:
            start, _, _ = law_at(model, model.joint_law[row], recording.t[0])
            return float(2.0 * np.pi * np.round((start - angle_at) / (2.0 * np.pi)))
    return 0.0


def force_values(built: BuiltMechanism, of: str) -> tuple[str, Values]:
    """Return the unit, and what gives the size (k,) of a force or coupling, by its name.

    A force pushes its coordinate with this size, positive where the coordinate grows. A coupling
    pushes the first of its coordinates so, and the others in the ratio of its equation.
    """
    model, quantities = built.model, built.model.quantities
    if of in built.force_names:
        k = built.force_names.index(of)
        unit = _unit(int(quantities.kind[quantities.along[k]]))
        return unit, lambda recording: force_sizes(
            model, k, recording.t, recording.y, recording.multipliers
        )
    plain = model.joint_kind.size - n_coupling(model)
    c = built.joint_names[plain:].index(of)
    term, row = int(quantities.coupling_start[c]), int(model.joint_row[plain + c])
    ratio = float(quantities.coupling_ratio[term])
    unit = _unit(int(quantities.kind[quantities.coupling_coordinate[term]]))
    return unit, lambda recording: np.asarray(-ratio * recording.multipliers[:, row])


def _unit(kind: int) -> str:
    return "N m" if kind in (ANGLE, SPIN) else "N"
