"""Directions in which a body has no inertia of its own: mass points, thin rods, massless bodies.

The elimination divides by the mass matrix of each body (elimination.py), which is singular for
them. So inertia is added in these directions, M + sum sigma g g', and taken away again by a row
of its own:

    (M + sum sigma g g') a + ... + g mu = f,   g'a + mu / sigma = 0.

The equations are the same. The row has its place behind the constraints at the body, which must
hold the body in these directions; where they do not, no acceleration follows
(`undetermined_body`).
"""

from collections.abc import Sequence

import numpy as np

from ...math.arrays import Array, IntArray
from ..tolerances import HELD, MASS_ROUNDING, MOVED, POSITIVE_MASS


def missing_inertia(mass: float, J: Array, M_wq: Array, S0: Array, S: Array, M_qq: Array) -> Array:
    """Return the directions (d, 6 + m) in which a body at rest has no inertia.

    Unit vectors by translation in global and rotation in body axes, and modes: inertia added along
    them makes the body's mass matrix positive definite in every position.

    Parameters
    ----------
    mass : [kg]
    J : (3, 3) inertia about the frame [kg m2]
    M_wq, S : (3, m) coupling of the modes with rotation and translation
    S0 : (3,) first moment of mass [kg m]
    M_qq : (m, m) modal mass
    """
    x, y, z = S0
    top = np.hstack([mass * np.eye(3), -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), S])
    middle = np.hstack([top[:, 3:6].T, J, M_wq])
    M = np.vstack([top, middle, np.hstack([S.T, M_wq.T, M_qq])])
    scale = np.sqrt(np.diag(M).clip(min=0.0))
    scale[scale == 0.0] = 1.0
    values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
    null = vectors[:, values <= POSITIVE_MASS] / scale[:, None]
    if null.shape[1] == 0:
        return np.zeros((0, len(M)))
    moving = np.eye(len(M))[:3] if mass == 0.0 else np.zeros((0, len(M)))
    # with mass, no motion without inertia is a translation alone: the rest says which it is
    U, s, _ = np.linalg.svd(null[3:])
    other = np.zeros((int(np.sum(s > MOVED * max(s[0], 1e-300))), len(M)))
    other[:, 3:] = U[:, : len(other)].T
    return np.vstack([moving, other])


def undetermined_body(
    M: Array, Phi_q: Array, inertia_scale: Array, vel_start: IntArray
) -> tuple[int, Array] | None:
    """Return a body whose acceleration does not follow from loads and constraints; None: all do.

    Its number comes with the direction (6,), translation and rotation, in which it is free to
    move without inertia.

    Parameters
    ----------
    M : (n, n) mass matrix of a mechanism
    Phi_q : (n_c, n)
    inertia_scale : (n,) above zero
    vel_start : (nb,) first velocity coordinate of each body
    """
    root = np.sqrt(inertia_scale)
    C = Phi_q / root
    size = np.linalg.norm(C, axis=1, keepdims=True)
    s, Vt = np.linalg.svd(C / np.where(size > 0.0, size, 1.0))[1:]
    Z = Vt[int(np.sum(s > HELD * max(s[0], 1e-300))) if s.size else 0 :].T
    if Z.shape[1] == 0:
        return None
    values, vectors = np.linalg.eigh(Z.T @ (M / np.outer(root, root)) @ Z)
    if values[0] > MASS_ROUNDING:
        return None
    free = (Z @ vectors[:, 0]) / root
    share = [float(np.linalg.norm((free * root)[j : j + 6])) for j in vel_start]
    body = int(np.argmax(share))
    direction = free[vel_start[body] : vel_start[body] + 6]
    return body, direction / np.linalg.norm(direction)


def inertia_of(directions: Sequence[Array], scale: Array, start: np.ndarray) -> Array:
    """Return the inertia (n_a,) added in each direction: of the size of that of other bodies.

    Parameters
    ----------
    directions : directions (d, 6 + m) of each body without inertia
    scale : inertia scale of the velocity coordinates (n_vel,)
    start : first velocity of each body (nb + 1,)
    """
    moving = max((scale[j] for j in start[:-1]), default=0.0) or 1.0
    turning = max((scale[j + 3] for j in start[:-1]), default=0.0) or 1.0
    inertia = []
    for body, j in zip(directions, start[:-1], strict=True):
        for g in body:
            own = float(g**2 @ scale[j : j + g.size])
            inertia.append(own or (moving if g[:3].any() else turning))
    return np.array(inertia, dtype=float)


def is_positive(M: Array) -> bool:
    """Return whether a modal mass matrix is positive definite; one without modes is."""
    scale = np.sqrt(np.diag(M).clip(min=1e-300))
    return not M.size or bool(np.linalg.eigvalsh(M / np.outer(scale, scale))[0] > POSITIVE_MASS)


def of_one_length(directions: Sequence[Array]) -> Array:
    """Return directions of several bodies as rows of one length, (n_a, widest)."""
    widest = max((d.shape[1] for d in directions), default=6)
    rows = [np.pad(d, ((0, 0), (0, widest - d.shape[1]))) for d in directions]
    return np.concatenate([np.zeros((0, widest)), *rows])
