"""What accelerations and multipliers leave of the equations of motion.

A solution of a mechanism with rigid bodies, put into the same mechanism with flexible bodies,
leaves loads on the modes: those that would deform the bodies.
"""

import numpy as np

from ..math.arrays import Array
from ..math.compiled import lean
from .evaluation import evaluate
from .model import Model
from .workspace import Work, spare_work


def residuals(model: Model, t: Array, y: Array, accelerations: Array, multipliers: Array) -> Array:
    """Return f - M a - Phi_q' lambda, (k, n_vel).

    At times t (k,) and states y (k, n), with accelerations (k, n_vel) and multipliers (k, n_c).
    """
    found = np.zeros((len(t), model.n_vel))
    t, y, a, s = (
        np.ascontiguousarray(part, dtype=float) for part in (t, y, accelerations, multipliers)
    )
    _residuals(model, spare_work(model), t, y, a, s, found)
    return found


@lean
def _residuals(
    model: Model, work: Work, t: Array, y: Array, a: Array, multipliers: Array, found: Array
) -> None:
    plan = model.plan
    for k in range(t.shape[0]):
        evaluate(model, work, t[k], y[k])
        for i in range(model.n_body):
            j, n = model.vel_start[i], plan.size[i]
            for c in range(n):
                left = work.f[i, c]
                for d in range(n):
                    m = work.M[i, c, d] if d <= c else work.M[i, d, c]
                    left -= m * a[k, j + d]
                found[k, j + c] = left
        for joint in range(model.joint_kind.shape[0]):
            begin = model.joint_row[joint]
            for side in range(2):
                body = model.marker_body[model.joint_marker[joint, side]]
                if body >= 0:
                    j, first = model.vel_start[body], plan.side_row[joint, side]
                    for p in range(model.joint_row[joint + 1] - begin):
                        for c in range(plan.size[body]):
                            push = work.J[body, c, first + p] * multipliers[k, begin + p]
                            found[k, j + c] -= push
