"""Energies that positions alone decide: strain and weight."""

import numpy as np

from ..math.arrays import Array
from ..math.rotations import rotation_matrices
from .bodies.second_order import second_order_first_moment
from .model import Model


def stored_energies(model: Model, y: Array) -> Array:
    """Return strain and weight's energy at states y (k, n), (k, 2) [J]. Paper: Eq. (3).

    That of weight is zero for a mass point at the global origin.
    """
    found = np.zeros((len(y), 2))
    for i in range(model.n_body):
        a, m = int(model.pos_start[i]), int(model.n_mode[i])
        two = int(model.square_start[i])
        q = y[:, a + 7 : a + 7 + m]
        found[:, 0] += 0.5 * np.einsum(
            "ki,ki->k", q, q @ model.K_qq[two : two + m * m].reshape(m, m).T
        )
        A = rotation_matrices(y[:, a + 3 : a + 7])
        centre = np.einsum("kab,kb->ka", A, first_moments(model, i, q))
        found[:, 1] -= (model.mass[i] * y[:, a : a + 3] + centre) @ model.gravity_G
    return found


def first_moments(model: Model, i: int, q: Array) -> Array:
    """Return the first moments of mass (k, 3) of body i about its frame, body axes [kg m].

    q (k, m) are its modal coordinates.
    """
    one, m = int(model.mode_start[i]), int(model.n_mode[i])
    S = model.S[3 * one : 3 * (one + m)].reshape(3, m)
    first = model.S0[i] + q @ S.T
    if model.second_start[i + 1] > model.second_start[i]:
        first = first + second_order_first_moment(model, i, q)
    return np.asarray(first)
