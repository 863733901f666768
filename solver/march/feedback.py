"""Newton's matrix with the feedback of Baumgarte's treatment.

Constraints with feedback leave c = gamma - Phi_q vdot - 2 alpha Phidot - beta^2 Phi. A change x of
positions and delta v = s x - rho of velocities answers with

    Phi_q x = (c + (s + 2 alpha) Phi_q rho) / d,   d = s^2 + 2 alpha s + beta^2,

where the pencil (pencil.py) has (c' + s Phi_q rho) / s^2: the same, for

    c' = (s^2 c - s beta^2 Phi_q rho) / d.

Without it Newton's iteration converges only where steps are much shorter than 1 / alpha, 1 / beta.
"""

from ..compiled import lean
from ..model import Model
from .pencil import Frozen, Pencil, _spin_of


@lean
def feed_back(model: Model, frozen: Frozen, pencil: Pencil, s: complex) -> None:
    """Make c' of c in pencil.gamma (n_c,), with rho of pencil.r."""
    gamma, r, rho, plan = pencil.gamma, pencil.r, pencil.rho, model.plan
    d = s * s + 2.0 * model.alpha * s + model.beta**2
    c = s * s / d
    for k in range(gamma.shape[0]):
        gamma[k] *= c
    c = s * model.beta**2 / d
    for i in range(model.n_body):
        a, first = model.pos_start[i], plan.row_start[i]
        _spin_of(frozen.p[i], r, a + 3, rho[i])
        for k in range(3):
            rho[i, k] = r[a + k]
        for k in range(model.n_mode[i]):
            rho[i, 6 + k] = r[a + 7 + k]
        for p in range(plan.row_start[i + 1] - first):
            for k in range(plan.size[i]):
                gamma[plan.body_row[first + p]] -= c * frozen.J[i, k, p] * rho[i, k]
