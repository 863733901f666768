"""Joint coordinates and joint reactions."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..dynamics.bodies.marker import Marker
from ..dynamics.joints.table import KINDS
from ..dynamics.system import law_at
from ..math.arrays import Array
from ..mechanism import BuiltJoint
from .recording import Recording

_DISPLACEMENTS = {"x": 0, "y": 1, "z": 2}
ROTATION = KINDS["rotation_drive"]


def joint_coordinate(joint: BuiltJoint, coordinate: str) -> Callable[[Recording], Array]:
    """Return the function for a coordinate (k,) of a joint, zero at its given start [rad or m]."""
    if coordinate in _DISPLACEMENTS:
        axis = _DISPLACEMENTS[coordinate]
        return lambda recording: _shifts(recording, joint)[:, axis] - joint.shift[axis]
    return lambda recording: _angles(recording, joint, second=coordinate == "angle_2")


def reaction(joint: BuiltJoint, table: dict[str, Any]) -> Callable[[Recording], Array]:
    """Return the function for the force or moment (k, 3) of a joint and its drives on one side."""

    def vectors(recording: Recording) -> Array:
        both = recording.reactions(joint.rows, table["side"])
        found = both[:, :3] if table["quantity"] == "force" else both[:, 3:]
        if table["axes"] == "joint":
            one, _ = _ends(recording, joint)
            found = np.array([m.A.T @ v for m, v in zip(one, found, strict=True)])
        return found

    return vectors


def _ends(recording: Recording, joint: BuiltJoint) -> tuple[list[Marker], list[Marker]]:
    one, two = (int(k) for k in recording.model.joint_marker[joint.rows[0]])
    return recording.motions(one), recording.motions(two)


def _shifts(recording: Recording, joint: BuiltJoint) -> Array:
    """Return the vector (k, 3) from place one to two in axes of place one [m]."""
    one, two = _ends(recording, joint)
    return np.array([a.A.T @ (b.x - a.x) for a, b in zip(one, two, strict=True)])


def _angles(recording: Recording, joint: BuiltJoint, *, second: bool) -> Array:
    """Return the angle (k,) about the first axis, or the second of a universal, unwrapped [rad].

    The number of turns between two output times follows from the rates at both. It is correct if
    their mean gives the rotation to within half a turn.
    """
    one, two = _ends(recording, joint)
    if second:
        pairs = [_angle(b, a, 2, 1, 2) for a, b in zip(one, two, strict=True)]
    else:
        pairs = [_angle(a, b, 0, 1, 0) for a, b in zip(one, two, strict=True)]
    angle, rate = np.array(pairs).T
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(recording.t)
    off = np.diff(angle) - steps
    steps += off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))
    first = angle[0] + _turns(recording, joint, angle[0])
    return np.concatenate([[first], first + np.cumsum(steps)])


def _angle(frame: Marker, arm: Marker, i: int, j: int, k: int) -> tuple[float, float]:
    """Angle [rad] and rate [rad/s] of axis k of `arm` from axis i of `frame` towards axis j."""
    x, y, a = frame.A[:, i], frame.A[:, j], arm.A[:, k]
    u, v = x @ a, y @ a
    n = (u * np.cross(a, y) - v * np.cross(a, x)) / (u * u + v * v)
    return float(np.arctan2(v, u)), float(n @ (arm.w - frame.w))


def _turns(recording: Recording, joint: BuiltJoint, angle: float) -> float:
    """Full turns [rad] of the value of a drive at its start."""
    model = recording.model
    for row in joint.rows[1:]:
        if model.joint_kind[row] == ROTATION:
            start, _, _ = law_at(model, model.joint_law[row], recording.t[0])
            return float(2.0 * np.pi * np.round((start - angle) / (2.0 * np.pi)))
    return 0.0
