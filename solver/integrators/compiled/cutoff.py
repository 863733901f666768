"""Errors without what is due to vibrations above a cutoff, and the energy that these lose.

A vibration that short steps have resolved keeps them short: Radau damps it by 1e-4 a step at
h w = 1, and its error grows as the step does. A filter takes out of the error e what modes above
the cutoff w_c have in it, for positions and velocities alike:

    (w_c^2 M + K) x + Phi_q' mu = w_c^2 M e,   Phi_q x = 0,

PASSES times, which leaves (1 + w^2 / w_c^2)^-PASSES of a mode of frequency w, and all of a motion
without stiffness. Steps then grow, and what they no longer resolve dies out (L-stability).

What the energy loses in a step that is accepted by the filter only is booked as damped. All other
steps are left to the checks of the balance.
"""

from typing import NamedTuple

import numpy as np

from ...dynamics.evaluation.elimination import solve
from ...dynamics.evaluation.energies import energies_into
from ...dynamics.evaluation.evaluation import evaluate
from ...dynamics.model.model import Model, Workspace, state_size
from ...math.arrays import Array
from ...math.compiled import lean, structure
from ...math.rotations import along_parameters
from .pencil import Frozen, Pencil, factorise_pencil, new_pencil, spin_of

PASSES = 3


@structure
class Cutoff(NamedTuple):
    """Memory of the filter."""

    pencil: Pencil
    held: Frozen  # that of the step, but for the stiffness of elements: the least so far
    error: Array  # (n,) filtered
    parts: Array  # (3,) of the energy [J]


def new_cutoff(model: Model, frozen: Frozen, least: Array) -> Cutoff:
    """Return memory; `least` (n_e,) is the least stiffness that elements have had.

    A stop that stands open, or a spring that goes slack, has no stiffness then: its contact is an
    event of the motion, and stays under error control. So do motions that tension holds.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : matrices of the last evaluation that Newton's matrix uses
    least : least stiffness that each element row has had (n_e,) [N/m, N m/rad]
    """
    n = state_size(model)
    held = frozen._replace(stiffness=least, tension=np.zeros_like(frozen.tension))
    return Cutoff(new_pencil(model, 1.0), held, np.zeros(n), np.zeros(3))


@lean
def start_filter(model: Model, frozen: Frozen, cutoff: Cutoff, w_c: float) -> None:
    """Factorise the filter for the matrices of a step.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : matrices of the last evaluation that Newton's matrix uses
    cutoff : memory of the filter
    w_c : cutoff frequency [rad/s]
    """
    least = cutoff.held.stiffness
    for k in range(least.shape[0]):
        least[k] = min(least[k], frozen.stiffness[k])
    factorise_pencil(model, cutoff.held, cutoff.pencil, w_c * w_c, 0.0, 1.0)


@lean
def filter_error(model: Model, cutoff: Cutoff, w_c: float, e: Array) -> None:
    """Fill cutoff.error (n,) with e (n,), less its parts above |w_c| [rad/s].

    With w_c < 0 velocities alone lose theirs, and positions keep all.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    cutoff : memory of the filter; its `error` is filled
    w_c : cutoff frequency [rad/s]; below 0: of velocities alone
    e : error (n,)
    """
    layout, pencil, held, out = model.layout, cutoff.pencil, cutoff.held, cutoff.error
    x, load, n_pos = pencil.x, pencil.load, model.n_pos
    for k in range(n_pos + model.n_vel, out.shape[0] - 1):
        out[k] = e[k]  # auxiliary states
    out[out.shape[0] - 1] = 0.0  # the work: a quadrature, that of vibrations is not resolved
    first = 0 if w_c > 0.0 else 1
    for k in range(n_pos if first else 0):
        out[k] = e[k]
    for part in range(first, 2):
        for i in range(model.n_body):
            a, j = model.pos_start[i], n_pos + model.vel_start[i]
            if part == 1:
                for k in range(layout.size[i]):
                    x[i, k] = e[j + k]
            else:
                spin_of(held.p[i], e, a + 3, x[i])
                for k in range(3):
                    x[i, k] = e[a + k]
                for k in range(model.n_mode[i]):
                    x[i, 6 + k] = e[a + 7 + k]
        for _ in range(PASSES):
            for i in range(model.n_body):
                M, lead = held.M[i], layout.lead[i]
                for k in range(layout.size[i]):
                    z = w_c * w_c * x[i, k]
                    s = M[k, k] * z
                    for b in range(min(k, lead)):
                        s += w_c * w_c * M[k, b] * x[i, b]
                        load[i, b] += M[k, b] * z
                    load[i, k] = s
            pencil.gamma[:] = 0.0
            solve(layout, layout.newton, pencil.factors, load, pencil.gamma, x, pencil.mu)
        for i in range(model.n_body):
            a, j = model.pos_start[i], n_pos + model.vel_start[i]
            if part == 1:
                for k in range(layout.size[i]):
                    out[j + k] = x[i, k]
            else:
                turn = 0.5 * x[i, 3], 0.5 * x[i, 4], 0.5 * x[i, 5]
                turned = along_parameters(held.p[i], 0, turn[0], turn[1], turn[2])
                for k in range(3):
                    out[a + k] = x[i, k]
                for k in range(4):
                    out[a + 3 + k] = turned[k]
                for k in range(model.n_mode[i]):
                    out[a + 7 + k] = x[i, 6 + k]


@lean
def energy(model: Model, work: Workspace, t: float, y: Array, parts: Array) -> float:
    """Return the energy of state y (n,) at t [J]; `parts` (3,) is filled with its parts.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    parts : kinetic, strain and potential energy (3,) [J], to fill
    """
    evaluate(model, work, t, y)
    energies_into(model, work, y, parts)
    return float(parts[0] + parts[1] + parts[2])
