"""Gaps of joints in words."""

import numpy as np

from ..dynamics.joints.table import NAMES, ROWS
from ..dynamics.model import Model
from ..errors import few
from ..math.arrays import Array


def rows_of(model: Model, joint: int) -> slice:
    """Return the rows of a joint."""
    return slice(int(model.joint_row[joint]), int(model.joint_row[joint + 1]))


def described_gaps(
    model: Model, residual: Array, names: list[str], words: tuple[str, str], least: float = 1e-9
) -> str:
    """List the joints with residuals above `least`, largest first."""
    parts = []
    for k, name in enumerate(names):
        r = residual[rows_of(model, k)]
        units = ROWS[NAMES[model.joint_kind[k]]]
        distance = np.array([unit == "d" for unit in units])
        shift, turn = float(np.linalg.norm(r[distance])), float(np.linalg.norm(r[~distance]))
        if max(shift, turn) > least:
            parts.append(
                (max(shift, turn), f"{name}: {shift:.4g} {words[0]}, {turn:.4g} {words[1]}")
            )
    return few((text for _, text in sorted(parts, reverse=True)), "; ")
