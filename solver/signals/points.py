"""Motion of places of bodies: global motion, orientation, elastic deflection and rotation."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.analysis.motions.table import MOTIONS
from ..dynamics.analysis.recovery import Recording, stiffened
from ..math.arrays import Array, quadratic_forms
from ..math.compiled import lean
from ..math.rotations import shortest_rotations, vector_of, vector_to_matrix, vectors_to_matrices
from ..mechanism.built_mechanism import BuiltMechanism, frame_marker
from ..package.body.package_schema import Interface

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import PointSignal

POINT_UNITS = {kind: motion.unit for kind, motion in MOTIONS.items()}
POINT_UNITS |= {"orientation": "rad", "deflection": "m", "rotation": "rad"}


def elastic_motion(place: Interface, q: Array, second_order: bool) -> tuple[Array, Array]:
    """Return translation (k, 3) [m] and rotation vector (k, 3) [rad] of an interface in its body.

    phi q and psi q, and with `second_order` 1/2 q' H q of both. q : (k, m) modal coordinates.

    Parameters
    ----------
    place : interface of the package
    q : modal coordinates (k, m)
    second_order : with the terms of second order
    """
    u, theta = q @ place.phi_B.T, q @ place.psi_B.T
    if second_order and place.H_B is not None and place.H_psi_B is not None:
        u = u + 0.5 * quadratic_forms(place.H_B, q)
        theta = theta + 0.5 * quadratic_forms(place.H_psi_B, q)
    return u, theta


def point_values(
    built: BuiltMechanism, name: str, signal: "PointSignal"
) -> Callable[[Recording], Array]:
    """Return what gives the vectors (k, 3) of a signal of a place.

    Parameters
    ----------
    built : the built mechanism
    name : name of the signal
    signal : its table in the case
    """
    kind = signal.kind
    if kind in ("deflection", "rotation"):
        return _of_segments(built, name, signal) if signal.frame else _elastic(built, signal)
    marker = built.signal_marker[name]
    if kind in MOTIONS:
        return lambda recording: MOTIONS[kind].vectors(recording, marker)
    key = object()

    def vectors(recording: Recording) -> Array:
        def compute(before: Array | None) -> tuple[Array, Array]:
            turns = rotation_vectors(recording.axes(marker), before)
            return turns, turns[-1].copy()

        return recording.carried(key, compute)

    return vectors


def _elastic(built: BuiltMechanism, signal: "PointSignal") -> Callable[[Recording], Array]:
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
        turned = vectors_to_matrices(turn)
        return np.asarray(np.einsum("kba,kb->ka", turned, arm + u - u_eye) - arm)

    return seen


def _of_segments(
    built: BuiltMechanism, name: str, signal: "PointSignal"
) -> Callable[[Recording], Array]:
    """Return what gives the deflection or rotation (k, 3) of an interface of a body in segments.

    The frame moves with its first place. Through two places, it is rotated further by the shortest
    way until its chord runs through the second.
    """
    frame, at = signal.frame, built.signal_marker[name]
    assert frame is not None
    carriers = [built.signal_marker[frame_marker(name, i)] for i in range(len(frame.places))]
    A_start = vector_to_matrix(np.radians(np.array(frame.rotation_deg)))
    rest = np.array(frame.rest)

    def values(recording: Recording) -> Array:
        origin, A = recording.position(carriers[0]), recording.axes(carriers[0])
        if frame.chord is not None:
            now = A @ (np.array(frame.chord) / np.linalg.norm(frame.chord))
            to = recording.position(carriers[1]) - origin
            A = shortest_rotations(now, to) @ A
        if signal.kind == "rotation":
            turned = A.transpose(0, 2, 1) @ recording.axes(at) @ A_start
            return rotation_vectors(turned)
        arm = recording.position(at) - origin
        return np.asarray(np.einsum("kba,kb->ka", A, arm) - rest)

    return values


def rotation_vectors(matrices: Array, before: Array | None = None) -> Array:
    """Return rotation vectors (k, 3) of matrices (k, 3, 3) without jumps [rad].

    A rotation vector is determined up to full turns about its axis. The one closest to the
    previous one is used; `before` (3,) is that before the first.
    """
    vectors = np.zeros((len(matrices), 3))
    _rotation_vectors(
        np.ascontiguousarray(matrices), np.zeros(3) if before is None else before, vectors
    )
    return vectors


@lean
def _rotation_vectors(A: Array, before: Array, vectors: Array) -> None:
    b0, b1, b2 = before[0], before[1], before[2]  # the previous one
    for k in range(A.shape[0]):
        x = (A[k, 0, 0], A[k, 1, 0], A[k, 2, 0])
        y = (A[k, 0, 1], A[k, 1, 1], A[k, 2, 1])
        z = (A[k, 0, 2], A[k, 1, 2], A[k, 2, 2])
        t0, t1, t2 = vector_of(x, y, z)
        angle = np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
        size = np.sqrt(b0 * b0 + b1 * b1 + b2 * b2)
        # Without rotation or at full turns, use the previous axis.
        if angle > 1e-9:
            a0, a1, a2 = t0 / angle, t1 / angle, t2 / angle
        else:
            a0, a1, a2 = b0 / max(size, 1e-9), b1 / max(size, 1e-9), b2 / max(size, 1e-9)
        turns = np.floor((b0 * a0 + b1 * a1 + b2 * a2 - angle) / (2.0 * np.pi) + 0.5)
        whole = angle + 2.0 * np.pi * turns
        b0, b1, b2 = whole * a0, whole * a1, whole * a2
        vectors[k, 0], vectors[k, 1], vectors[k, 2] = b0, b1, b2
