"""Geometric stiffness of a body in a state of motion.

The accelerations of a state are held while a body bends a little further. What its elastic forces
then gain beside K q is the geometric stiffness: of its own inertia loads and weight (Z0, Z1, G3),
and of the forces and moments at its markers (H).
"""

import numpy as np

from ..dynamics.bodies.second_order import stiffening_matrix
from ..dynamics.model import Model
from ..dynamics.reactions import marker_loads
from ..dynamics.system import accelerations, assemble
from ..math.arrays import Array
from ..math.rotations import rotation_matrix


def geometric_stiffness(model: Model, tables: Model, i: int, t: float, y: Array) -> Array:
    """Return the geometric stiffness (m, m) of body i at time t and state y (n,) [N m].

    `tables` is a model of the same mechanism whose body i is of second order; accelerations and
    joint forces are those of `model`.
    """
    m, a, j = int(model.n_mode[i]), int(model.pos_start[i]), int(model.vel_start[i])
    equations = assemble(model, t, y)
    v_d, multipliers = accelerations(model, equations, y)
    A = rotation_matrix(y[a + 3 : a + 7])
    w = y[model.n_pos + j + 3 : model.n_pos + j + 6]
    pull = A.T @ (v_d[j : j + 3] - model.gravity_G)
    Kg = stiffening_matrix(tables, i, w, v_d[j + 3 : j + 6], pull, v_d[j + 6 : j + 6 + m])
    for marker, force, moment in marker_loads(model, t, y, equations.C, multipliers):
        start = int(tables.marker_second[marker])
        if model.marker_body[marker] == i and start >= 0:
            H = tables.marker_H[start : start + 6 * m * m].reshape(6, m, m)
            load_B = np.concatenate([A.T @ force, A.T @ moment])
            Kg = Kg - np.einsum("a,aij->ij", load_B, H)
    return np.asarray(0.5 * (Kg + Kg.T))
