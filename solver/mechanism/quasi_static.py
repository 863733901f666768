"""Quasi-static start: bodies begin with the shape that their loads at t = 0 call for.

A body that starts undeformed under loads vibrates in all its modes about the shape that the loads
call for: the reactions contain frequencies without an upper limit. In a quasi-static start the
mechanism moves from t = 0 on as its joints and drives prescribe, with shapes that are constant at
this instant. Each iteration holds the shapes, computes the loads of the motion, and deforms the
bodies by K^-1 times what these loads leave.
"""

from dataclasses import replace

import numpy as np

from ..dynamics.held import held_deformations
from ..dynamics.model import Model
from ..errors import InputError, few
from ..math.arrays import Array
from .initial import Start, consistent_state

_TOLERANCE = 1e-8  # of the change of the shapes, in the norm of the strain energy
_DIVERGED = 1e8  # energy of a change, of that of the first
_NOTHING = 1e-20  # strain energy over that of the first change that is round-off
_MAX_ITERATIONS = 40


def quasi_static_state(
    model: Model, start: Start, y: Array, joint_names: list[str], body_names: list[str]
) -> Array:
    """Return the state (n,) in which the shapes of all bodies balance the loads at t = 0.

    Parameters
    ----------
    y : (n,) `consistent_state` of `start`

    Raises
    ------
    InputError
        As `consistent_state`; the shapes do not converge: the loads of a body grow with its
        deformation (buckling, a spin above its first frequency), or joints do not let the
        mechanism move while the shapes are held.
    """
    first = 0.0
    energies = np.zeros(model.n_body)
    for _ in range(_MAX_ITERATIONS):
        changes = held_deformations(model, 0.0, y)
        energies = np.array([_energy(model, i, change) for i, change in enumerate(changes)])
        first = first or float(energies.sum())
        if not np.isfinite(first) or energies.sum() <= _NOTHING * first:
            break
        if not energies.sum() < _DIVERGED * first:
            raise _not_converged(body_names, energies)
        y = y.copy()
        whole = 0.0
        for i, change in enumerate(changes):
            a = int(model.pos_start[i]) + 7
            y[a : a + len(change)] += change
            whole += _energy(model, i, y[a : a + len(change)])
        y = consistent_state(model, replace(start, positions=y[: model.n_pos]), joint_names)
        if energies.sum() <= _TOLERANCE**2 * whole:
            break
    else:
        raise _not_converged(body_names, energies)
    return y


def _not_converged(body_names: list[str], energies: Array) -> InputError:
    worst = [name for name, e in zip(body_names, energies, strict=False) if e == energies.max()]
    return InputError(
        f'solver.start = "quasi-static": the shape of {few(worst)} does not converge: its '
        "loads at t = 0 grow with its deformation, or the mechanism cannot move with rigid "
        'bodies. Expected start = "positions" or "equilibrium" here'
    )


def _energy(model: Model, body: int, q: Array) -> float:
    m, square = len(q), int(model.square_start[body])
    K = model.K_qq[square : square + m * m].reshape(m, m)
    return float(q @ K @ q)
