"""Absolute tolerances of the state from the keys of `[solver]` and the scales of a mechanism."""

from typing import Protocol

import numpy as np

from ..dynamics.model import Model, state_size
from ..dynamics.scales import scales, shape_sizes
from ..math.arrays import Array

# The work enters the energy balance alone, no motion depends on it. The estimate of the error of a
# quadrature by radau is of order 3 and contains the reactions' vibrations: with a share of 1, an
# arm with a smooth drive takes 1.8 times the steps at the same error of motion and balance.
WORK_SHARE = 10.0


class ToleranceKeys(Protocol):
    """The keys of `[solver]` that set the tolerances of a step."""

    @property
    def t_end(self) -> float:
        """End of the run [s]."""

    @property
    def rtol(self) -> float:
        """Accuracy asked for, relative."""

    @property
    def atol_position(self) -> float | None:
        """Absolute tolerance of positions and modal coordinates; None: rtol times their scales."""

    @property
    def atol_velocity(self) -> float | None:
        """Absolute tolerance of velocities and modal rates; None: rtol times their scales."""


def tolerances(model: Model, y0: Array, solver: ToleranceKeys, rtol: float) -> Array:
    """Return absolute tolerances (n,) of positions, velocities and the work of a run from y0 (n,).

    With L, V and E of scales.py, and d_j the displacement by mode j: rtol L of positions, rtol of
    Euler parameters, rtol L / d_j of modal coordinates; rtol V, rtol V / L and rtol V / d_j of
    their rates; WORK_SHARE rtol E of the work. The keys of a case have precedence, for all
    components alike.
    """
    size = scales(model, y0, solver.t_end)
    atol = np.full(state_size(model), size.energy)
    v_end = model.n_pos + model.n_vel
    atol[v_end : v_end + model.n_aux] = model.quantities.scale
    for i in range(model.n_body):
        shapes = shape_sizes(model, i)
        a, j = int(model.pos_start[i]), model.n_pos + int(model.vel_start[i])
        atol[a : a + 3], atol[j : j + 3] = size.length, size.speed
        atol[a + 3 : a + 7], atol[j + 3 : j + 6] = 1.0, size.speed / size.length
        ends = a + 7 + shapes.size, j + 6 + shapes.size
        atol[a + 7 : ends[0]], atol[j + 6 : ends[1]] = size.length / shapes, size.speed / shapes
    atol[-1] *= WORK_SHARE
    atol *= rtol
    if solver.atol_position is not None:
        atol[: model.n_pos] = solver.atol_position
    if solver.atol_velocity is not None:
        atol[model.n_pos : v_end] = solver.atol_velocity
        atol[-1] = solver.atol_velocity
    return atol


def blocks(model: Model) -> list[int]:
    """Return the first index of each block of the error norm: positions of each body, velocities
    of each body, auxiliary states, work.
    """
    j = model.n_pos + np.asarray(model.vel_start)
    more = range(model.n_pos + model.n_vel, state_size(model))
    return [*map(int, model.pos_start), *map(int, j), *more]
