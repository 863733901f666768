"""How places of bodies move: global motion, orientation, elastic deflection and rotation."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..mechanism import BuiltMechanism
from ..package.schema import Array
from ..recover import second_order_motion, stiffened
from ..rotations import matrix_to_vector
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
    built: BuiltMechanism, name: str, table: dict[str, Any]
) -> Callable[[Recording], Array]:
    """Return what gives the vectors (k, 3) of a signal of a place."""
    kind = table["kind"]
    if kind in ("deflection", "rotation"):
        body, interface = built.places[table["at"]]
        shapes = interface.phi_B if kind == "deflection" else interface.psi_B
        H = interface.H_B if kind == "deflection" else interface.H_psi_B
        if H is None or not stiffened(built.model, body):
            return lambda recording: recording.modes(body) @ shapes.T
        return lambda recording: second_order_motion(recording.modes(body), shapes, H)
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


def rotation_vectors(matrices: list[Array]) -> Array:
    """Return rotation vectors (k, 3) of matrices (3, 3) without jumps [rad].

    A rotation vector is known up to whole turns about its axis: the one nearest to the one
    before is taken.
    """
    found = np.zeros((len(matrices), 3))
    before = np.zeros(3)
    for k, A in enumerate(matrices):
        theta = matrix_to_vector(np.ascontiguousarray(A))
        angle = float(np.linalg.norm(theta))
        size = float(np.linalg.norm(before))
        # Without rotation, at whole turns, the axis is the one before.
        axis = theta / angle if angle > 1e-9 else before / max(size, 1e-9)
        turns = np.round((before @ axis - angle) / (2.0 * np.pi))
        before = found[k] = (angle + 2.0 * np.pi * turns) * axis
    return found
