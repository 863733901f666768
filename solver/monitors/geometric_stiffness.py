"""Geometric stiffness of a body in a state of motion.

The accelerations of a state are held while a body bends a little further. What its elastic forces
then gain beside K q is the geometric stiffness: of its own inertia loads and weight (Z0, Z1, G3),
and of the forces and moments at its markers (H).
"""

import numpy as np

from ..dynamics import series
from ..dynamics.bodies.second_order import stiffening_matrices
from ..dynamics.model import Model
from ..math.arrays import Array
from ..math.rotations import rotation_matrices


def geometric_stiffness(
    model: Model,
    tables: Model,
    i: int,
    t: Array,
    y: Array,
    along: tuple[Array, Array] | None = None,
) -> Array:
    """Return the geometric stiffness (k, m, m) of body i at times t (k,) and states y (k, n) [N m].

    `tables` is a model of the same mechanism whose body i is of second order; accelerations and
    joint forces are those of `model`, `along` its rates and multipliers if they are known.
    """
    m, a, j = int(model.n_mode[i]), int(model.pos_start[i]), int(model.vel_start[i])
    rates, multipliers = along or series.along_solution(model, t, y)
    v_d = rates[:, model.n_pos + j :]
    A = rotation_matrices(y[:, a + 3 : a + 7])
    w = y[:, model.n_pos + j + 3 : model.n_pos + j + 6]
    pull = np.einsum("kba,kb->ka", A, v_d[:, :3] - model.gravity_G)
    Kg = stiffening_matrices(tables, i, w, v_d[:, 3:6], pull, v_d[:, 6 : 6 + m])
    loads = series.marker_loads(model, t, y, multipliers)
    for place, marker in enumerate(series.loaded_markers(model).tolist()):
        start = int(tables.marker_second[marker])
        if model.marker_body[marker] == i and start >= 0:
            H = tables.marker_H[start : start + 6 * m * m].reshape(6, m, m)
            both = loads[:, place].reshape(-1, 2, 3)
            load_B = np.einsum("kba,ksb->ksa", A, both).reshape(-1, 6)
            Kg = Kg - np.tensordot(load_B, H, 1)
    return np.asarray(0.5 * (Kg + Kg.transpose(0, 2, 1)))
