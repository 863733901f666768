"""Geometric stiffness of a body in a state of motion.

The accelerations of a state are held while a body bends a little further. What its elastic forces
then gain beside K q is the geometric stiffness: of its own inertia loads and weight (Z0, Z1, G3),
and of the forces and moments at its markers (H).
"""

from dataclasses import dataclass, field

import numpy as np

from ...dynamics.elements.bodies.second_order import stiffening_matrices
from ...dynamics.evaluation import series
from ...dynamics.model.model import Model
from ...math.arrays import Array
from ...math.rotations import rotation_matrices

STATES = 8  # groups of states whose rates and loads are kept


@dataclass
class Loading:
    """Rates dy/dt (k, n) and marker loads (k, n_load, 6) of states, kept for all bodies.

    They are those of the whole mechanism: solved for each of its bodies anew, the cost of a look
    would be the square of the number of bodies.
    """

    model: Model
    _kept: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)

    def __call__(
        self, t: Array, y: Array, along: tuple[Array, Array] | None = None
    ) -> tuple[Array, Array]:
        """Return rates and loads at times t (k,) and states y (k, n) of one run.

        `along`: rates and multipliers, if they are known.
        """
        key = t.tobytes()
        found = self._kept.pop(key, None)
        if found is None:
            rates, multipliers = along or series.along_solution(self.model, t, y)
            found = rates, series.marker_loads(self.model, t, y, multipliers)
        self._kept[key] = found  # the last used is last
        if len(self._kept) > STATES:
            self._kept.pop(next(iter(self._kept)))
        return found


def geometric_stiffness(
    model: Model,
    tables: Model,
    i: int,
    t: Array,
    y: Array,
    loaded: tuple[Array, Array] | None = None,
) -> Array:
    """Return the geometric stiffness (k, m, m) of body i at times t (k,) and states y (k, n) [N m].

    `tables` is a model of the same mechanism whose body i is of second order; accelerations and
    joint forces are those of `model`; `loaded` as `Loading` returns them, if they are known.
    """
    m, a, j = int(model.n_mode[i]), int(model.pos_start[i]), int(model.vel_start[i])
    rates, loads = loaded or Loading(model)(t, y)
    v_d = rates[:, model.n_pos + j :]
    A = rotation_matrices(y[:, a + 3 : a + 7])
    w = y[:, model.n_pos + j + 3 : model.n_pos + j + 6]
    pull = np.einsum("kba,kb->ka", A, v_d[:, :3] - model.gravity_G)
    Kg = stiffening_matrices(tables, i, w, v_d[:, 3:6], pull, v_d[:, 6 : 6 + m])
    for place, marker in enumerate(series.loaded_markers(model).tolist()):
        start = int(tables.marker_second[marker])
        if model.marker_body[marker] == i and start >= 0:
            H = tables.marker_H[start : start + 6 * m * m].reshape(6, m, m)
            both = loads[:, place].reshape(-1, 2, 3)
            load_B = np.einsum("kba,ksb->ksa", A, both).reshape(-1, 6)
            Kg = Kg - np.tensordot(load_B, H, 1)
    return np.asarray(0.5 * (Kg + Kg.transpose(0, 2, 1)))
