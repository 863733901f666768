"""Energies and momenta of a mechanism in one state, after an evaluation there."""

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ...math.rotations import rotation_into
from ..model.model import (
    Model,
    Workspace,
)


@inlined
def energies_into(model: Model, work: Workspace, y: Array, out: Array) -> None:
    """Fill out (3,) with the energies of state y, after an evaluation there; see `energies`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    out : kinetic, strain and potential energy (3,) [J], to fill
    """
    kinetic = 0.0
    for i in range(model.n_body):
        j, M, lead = model.n_pos + model.vel_start[i], work.M[i], model.layout.lead[i]
        for a in range(model.layout.size[i]):
            momentum = 0.5 * M[a, a] * y[j + a]
            for b in range(min(a, lead)):
                momentum += M[a, b] * y[j + b]
            kinetic += y[j + a] * momentum
    out[0] = kinetic
    stored_energies(model, y, work.P, out)
    out[2] += work.power[1]


@inlined
def momenta_into(model: Model, work: Workspace, y: Array, out: Array) -> None:
    """Fill out (n_vel,) with M v of state y, after an evaluation there.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    y : state (n,), as in dynamics/model/model.py
    out : M v (n_vel,), to fill
    """
    for i in range(model.n_body):
        first, M = model.vel_start[i], work.M[i]
        j = model.n_pos + first
        for a in range(model.layout.size[i]):
            out[first + a] = 0.0
            for b in range(a + 1):
                out[first + a] += M[a, b] * y[j + b]
                if b < a:
                    out[first + b] += M[a, b] * y[j + a]


@lean
def stored_energies(model: Model, y: Array, A: Array, out: Array) -> None:
    """Fill strain energy and that of weight, out[1] and out[2] [J]; A (3, 3) is memory.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    y : state (n,), as in dynamics/model/model.py
    A : memory (3, 3)
    out : energies (3,) [J]; entries 1 and 2 are filled
    """
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
