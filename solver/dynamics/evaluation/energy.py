"""Energies of a state, in compiled code, and first moments of mass."""

import numpy as np

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ...math.rotations import rotation_into
from ..elements.bodies.second_order import second_order_first_moment
from ..model.model import Model
from ..model.workspace import Work


@inlined
def energies_into(model: Model, work: Work, y: Array, out: Array) -> None:
    """Fill out (3,) with the energies of state y, after an evaluation there; see `energies`."""
    kinetic = 0.0
    for i in range(model.n_body):
        j, M, lead = model.n_pos + model.vel_start[i], work.M[i], model.plan.lead[i]
        for a in range(model.plan.size[i]):
            momentum = 0.5 * M[a, a] * y[j + a]
            for b in range(min(a, lead)):
                momentum += M[a, b] * y[j + b]
            kinetic += y[j + a] * momentum
    out[0] = kinetic
    stored_energies(model, y, work.P, out)
    out[2] += work.power[1]


@inlined
def momenta_into(model: Model, work: Work, y: Array, out: Array) -> None:
    """Fill out (n_vel,) with M v of state y, after an evaluation there."""
    for i in range(model.n_body):
        first, M = model.vel_start[i], work.M[i]
        j = model.n_pos + first
        for a in range(model.plan.size[i]):
            out[first + a] = 0.0
            for b in range(a + 1):
                out[first + a] += M[a, b] * y[j + b]
                if b < a:
                    out[first + b] += M[a, b] * y[j + a]


@lean
def stored_energies(model: Model, y: Array, A: Array, out: Array) -> None:
    """Fill strain energy and that of weight, out[1] and out[2] [J]; A (3, 3) is memory."""
    strain, weight = 0.0, 0.0
    for i in range(model.n_body):
        p, m = model.pos_start[i], model.n_mode[i]
        one, two = 3 * model.mode_start[i], model.square_start[i]
        second = 12 * model.second_start[i]
        stiffened = model.second_start[i + 1] > model.second_start[i]
        rotation_into(y[p + 3 : p + 7], A)
        for k in range(m):
            force = 0.0
            for j in range(m):
                force += model.K_qq[two + k * m + j] * y[p + 7 + j]
            strain += 0.5 * y[p + 7 + k] * force
        for b in range(3):
            first = model.S0[i, b]
            for k in range(m):
                first += model.S[one + b * m + k] * y[p + 7 + k]
                if stiffened:
                    for j in range(m):
                        Z = model.Z[second + (b * m + k) * m + j]
                        first += 0.5 * Z * y[p + 7 + k] * y[p + 7 + j]
            for a in range(3):
                weight -= model.gravity_G[a] * A[a, b] * first
        for a in range(3):
            weight -= model.gravity_G[a] * model.mass[i] * y[p + a]
    out[1], out[2] = strain, weight


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
