"""Degrees of freedom of a mechanism."""

import numpy as np

from ..math.arrays import Array
from .constraints.minimum_norm import RANK_TOLERANCE
from .constraints.scaling import scaled_jacobian
from .joints.table import DRIVES, NAMES
from .model import Model
from .system import assemble


def degrees_of_freedom(model: Model, y: Array, t: float = 0.0) -> int:
    """Return the number of independent velocities in state y (n,) with joints but without drives.

    Modes are counted; drives do not reduce the number. In a singular position the number is
    larger than elsewhere.
    """
    Phi_q = assemble(model, t, y).Phi_q
    rows = [
        row
        for joint, kind in enumerate(model.joint_kind)
        if NAMES[kind] not in DRIVES
        for row in range(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))
    ]
    if not rows:
        return model.n_vel
    s = np.linalg.svd(scaled_jacobian(Phi_q[rows], model.inertia_scale), compute_uv=False)
    return int(model.n_vel - np.sum(s > RANK_TOLERANCE * s[0]))
