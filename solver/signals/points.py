"""Motion of places of bodies: global motion, orientation, elastic deflection and rotation."""

from collections.abc import Callable

import numpy as np

from ..dynamics.recover import elastic_motion, stiffened
from ..inputs.case.signals import PointSignal
from ..math.arrays import Array
from ..math.rotations import matrix_to_vector, vector_to_matrix
from ..mechanism import BuiltMechanism
from .recording import Recording

POINT_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "acceleration": "m/s2",
    "angular_velocity": "rad/s",
    "orientation": "rad",
    "deflection": "m",
    "rotation": "rad",
}


def point_values(
    built: BuiltMechanism, name: str, signal: PointSignal
) -> Callable[[Recording], Array]:
    """Return what gives the vectors (k, 3) of a signal of a place."""
    kind = signal.kind
    if kind in ("deflection", "rotation"):
        return _elastic(built, signal)
    marker = built.signal_marker[name]
    if kind == "position":
        return lambda recording: np.array([m.x for m in recording.motions(marker)])
    if kind == "velocity":
        return lambda recording: np.array([m.v for m in recording.motions(marker)])
    if kind == "angular_velocity":
        return lambda recording: np.array([m.w for m in recording.motions(marker)])
    if kind == "acceleration":
        return lambda recording: recording.acceleration(marker)
    return lambda recording: rotation_vectors([m.A for m in recording.motions(marker)])


def _elastic(built: BuiltMechanism, signal: PointSignal) -> Callable[[Recording], Array]:
    """Return what gives the deflection or elastic rotation (k, 3) of an interface."""
    body, at = built.places[signal.at]
    second_order = stiffened(built.model, body)
    if signal.kind == "rotation":
        return lambda recording: elastic_motion(at, recording.modes(body), second_order)[1]
    if signal.seen_from is None:
        return lambda recording: elastic_motion(at, recording.modes(body), second_order)[0]
    _, eye = built.places[signal.seen_from]
    arm = at.position_B - eye.position_B

    def seen(recording: Recording) -> Array:
        q = recording.modes(body)
        u, _ = elastic_motion(at, q, second_order)
        u_eye, turn = elastic_motion(eye, q, second_order)
        turned = np.array([vector_to_matrix(theta) for theta in turn])
        return np.asarray(np.einsum("kba,kb->ka", turned, arm + u - u_eye) - arm)

    return seen


def rotation_vectors(matrices: list[Array]) -> Array:
    """Return rotation vectors (k, 3) of matrices (3, 3) without jumps [rad].

    A rotation vector is determined up to full turns about its axis. The one closest to the
    previous one is used.
    """
    found = np.zeros((len(matrices), 3))
    before = np.zeros(3)
    for k, A in enumerate(matrices):
        theta = matrix_to_vector(np.ascontiguousarray(A))
        angle = float(np.linalg.norm(theta))
        size = float(np.linalg.norm(before))
        # Without rotation or at full turns, use the previous axis.
        axis = theta / angle if angle > 1e-9 else before / max(size, 1e-9)
        turns = np.round((before @ axis - angle) / (2.0 * np.pi))
        before = found[k] = (angle + 2.0 * np.pi * turns) * axis
    return found
