"""Displacements along the velocity coordinates, in which tangents of a motion are written."""

import numpy as np

from ...dynamics.model.coordinates import move_rows
from ...dynamics.model.model import Model
from ...math.arrays import Array


def displacements(model: Model, q: Array, change: Array) -> Array:
    """Return the displacements (..., n_vel) that changes of positions q (..., n_pos) stand for."""
    found = np.empty((*q.shape[:-1], model.n_vel))
    for a, j, m in zip(model.pos_start, model.vel_start, model.n_mode, strict=True):
        found[..., j : j + 3] = change[..., a : a + 3]
        found[..., j + 6 : j + 6 + m] = change[..., a + 7 : a + 7 + m]
        p, dp = q[..., a + 3 : a + 7], change[..., a + 3 : a + 7]
        turn = p[..., :1] * dp[..., 1:] - dp[..., :1] * p[..., 1:]
        turn -= np.cross(p[..., 1:], dp[..., 1:])
        found[..., j + 3 : j + 6] = 2.0 * turn / (p * p).sum(axis=-1, keepdims=True)
    return found


def displaced(model: Model, y: Array, change: Array) -> Array:
    """Return states (n,) or (k, n) moved by changes (2 n_vel + n_aux,), or one for each."""
    found, n = np.atleast_2d(y).copy(), model.n_vel
    change = np.atleast_2d(change)
    found[:, model.n_pos : -1] += change[:, n:]
    move_rows(model, found, np.ascontiguousarray(change[:, :n]))
    return found.reshape(y.shape)


def normalise(model: Model, y: Array) -> None:
    """Give the Euler parameters of states y (k, n) length one, in place."""
    for a in model.pos_start:
        p = y[:, a + 3 : a + 7]
        p /= np.sqrt((p * p).sum(axis=1, keepdims=True))


def turning(model: Model, v: Array, x: Array) -> Array:
    """Return what the turning of body axes adds to the rate of x (k, n_vel, c): -w x rotations.

    v (k, n_vel): velocities.
    """
    found = np.zeros_like(x)
    for j in model.vel_start:
        w0, w1, w2 = (v[:, j + 3 + i, None] for i in range(3))
        x0, x1, x2 = (x[:, j + 3 + i] for i in range(3))
        found[:, j + 3] = w2 * x1 - w1 * x2
        found[:, j + 4] = w0 * x2 - w2 * x0
        found[:, j + 5] = w1 * x0 - w0 * x1
    return found
