"""Independent constraints and degrees of freedom of a mechanism."""

import numpy as np

from ..math.arrays import Array
from .constraints.minimum_norm import RANK_TOLERANCE
from .constraints.scaling import scaled_jacobian
from .dense_equations import assemble
from .dependence import is_tree
from .independence import new_independence
from .joints.table import DRIVES, NAMES
from .model import Model
from .singular_value import new_spectrum, smallest_at
from .workspace import spare_work

_INDEPENDENT = 1e3 * RANK_TOLERANCE  # smallest singular value of rows of length one


def degrees_of_freedom(model: Model, y: Array, t: float = 0.0, *, independent: bool = False) -> int:
    """Return the number of independent velocities in state y (n,) with joints but without drives.

    Modes are counted; drives do not reduce the number. In a singular position the number is
    larger than elsewhere. `independent`: no row depends on others in this state, as is known.
    """
    rows = [
        row
        for joint, kind in enumerate(model.joint_kind)
        if NAMES[kind] not in DRIVES
        for row in range(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))
    ]
    if not rows:
        return model.n_vel
    if independent or clearly_independent(model, y, t):
        return model.n_vel - len(rows)
    Phi_q = assemble(model, t, y).Phi_q
    s = np.linalg.svd(scaled_jacobian(Phi_q[rows], model.inertia_scale), compute_uv=False)
    return int(model.n_vel - np.sum(s > RANK_TOLERANCE * s[0]))


def clearly_independent(model: Model, y: Array, t: float = 0.0) -> bool:
    """Tell whether all constraints, drives too, are far from dependent in state y (n,).

    The time is linear in the number of bodies.
    """
    if not 0 < model.n_constraint <= model.n_vel:
        return False
    if is_tree(model):  # the singular value falls with the square of the length of a chain
        return True
    rows = new_independence(model)
    C, memory = np.zeros_like(rows.C), new_spectrum(rows)
    return smallest_at(model, spare_work(model), rows, memory, 0, t, y, C) > _INDEPENDENT
