"""Quasi-static start: bodies begin with the shape that their loads at t = 0 call for.

A body that starts undeformed under loads vibrates in all its modes about the shape that the loads
call for: the reactions contain frequencies without an upper limit. In a quasi-static start the
mechanism moves from t = 0 on as its joints and drives prescribe, with shapes that are constant at
this instant. Each iteration holds the shapes, computes the loads of the motion, and deforms the
bodies by K^-1 times what these loads leave.

A loop of hinges whose members twist as they bend cannot be closed by moving its members: they have
to deform further. The changes of the shapes then keep all joints closed.
"""

from dataclasses import replace

import numpy as np

from ..dynamics.dependence import is_tree
from ..dynamics.held import held_deformations, joined_deformations, motions_without_strain
from ..dynamics.model import Model
from ..dynamics.scales import extent, shape_sizes
from ..errors import InputError, few
from ..math.arrays import Array
from .initial import DEFORMED, Start, consistent_state, frames_close

_TOLERANCE = 1e-8  # of the change of the shapes, in the norm of the strain energy
_DIVERGED = 1e8  # energy of a change, of that of the first
_NOTHING = 1e-20  # strain energy over that of the first change that is round-off
_STILL = 1e-13  # displacement over the size that is round-off
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
    first, joined, rigid, tree = 0.0, False, 0, is_tree(model)
    energies, size = np.zeros(model.n_body), extent(model, y)
    for _ in range(_MAX_ITERATIONS):
        changes = (
            joined_deformations(model, 0.0, y, rigid)
            if joined
            else held_deformations(model, 0.0, y)
        )
        energies = np.array([_energy(model, i, change) for i, change in enumerate(changes)])
        first = first or float(energies.sum())
        moves = max(
            float(np.max(shape_sizes(model, i) * np.abs(change), initial=0.0))
            for i, change in enumerate(changes)
        )
        if not np.isfinite(first) or energies.sum() <= _NOTHING * first or moves <= _STILL * size:
            break
        if not energies.sum() < _DIVERGED * first:
            raise _not_converged(body_names, energies, joined=joined)
        before, whole = y, 0.0
        y = y.copy()
        for i, change in enumerate(changes):
            a = int(model.pos_start[i]) + 7
            y[a : a + len(change)] += change
            whole += _energy(model, i, y[a : a + len(change)])
        if not (joined or tree or frames_close(model, y)):
            joined, y, rigid = True, before, motions_without_strain(model, 0.0, before)
            continue
        deformed = replace(start, positions=y[: model.n_pos])
        y = consistent_state(model, deformed, joint_names, deforming=joined)
        if energies.sum() <= _TOLERANCE**2 * whole:
            break
    else:
        raise _not_converged(body_names, energies, joined=joined)
    return y


def _not_converged(body_names: list[str], energies: Array, *, joined: bool) -> InputError:
    why = (
        "its loads at t = 0 grow with its deformation, or the mechanism cannot move with rigid "
        "bodies"
    )
    if joined:
        why = f"the joints of a loop hold it. {DEFORMED}"
    worst = [name for name, e in zip(body_names, energies, strict=False) if e == energies.max()]
    return InputError(
        f'solver.start = "quasi-static": the shape of {few(worst)} does not converge: {why}. '
        'Expected start = "positions" or "equilibrium" here'
    )


def _energy(model: Model, body: int, q: Array) -> float:
    m, square = len(q), int(model.square_start[body])
    K = model.K_qq[square : square + m * m].reshape(m, m)
    return float(q @ K @ q)
