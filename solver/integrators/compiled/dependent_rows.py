"""Rows that depend on each other, in Newton's iteration of Radau IIA.

Redundant constraints agree with each other in closed positions only. At the stages of a step they
contradict each other by what these positions miss, and a Newton iteration that insists on all of
them finds no answer: the part of the multipliers without effect grows, from iteration to
iteration and from step to step. Where the matrices have softened rows (pencil.py), the stages
therefore solve

    Phi_q vdot - e (lambda - lambda_p) = gamma

with the softness e of the matrices and the predicted multipliers lambda_p. The motion is that of
the rows without e: where rows are independent, lambda_p is right up to the error of a prediction.
"""

from ...dynamics.linear_algebra.elimination import solve
from ...dynamics.model.model import Model
from ...math.compiled import inlined
from .newton.pencil import Frozen, factorise_feedback, factorise_pencil
from .radau_workspace import MU, NU, RadauWorkspace

# Of the softness, relative to the mass that a row moves. More: Newton's iteration needs shorter
# steps. Less: multipliers of rows that are nearly dependent are those of the last step.
PENALTY = 1e5
PASSES = 4


@inlined
def softened(frozen: Frozen) -> bool:
    """Tell whether the matrices treat rows as dependent."""
    return bool(frozen.softness.shape[0] > 0 and frozen.softness[0] > 0.0)


@inlined
def factorise_stages(model: Model, workspace: RadauWorkspace, h: float) -> int:
    """Factorise the matrices of a step of h, with the same softness in both; return how many."""
    frozen, real, pair = workspace.frozen, workspace.real, workspace.pair
    factorise_pencil(model, frozen, real, (MU / h) ** 2, MU / h, 1.0)
    hard = not softened(frozen)
    factorise_pencil(model, frozen, pair, (NU / h) * (NU / h), NU / h, 1.0)
    again = hard and softened(frozen)
    if again:
        factorise_pencil(model, frozen, real, (MU / h) ** 2, MU / h, 1.0)
    factorise_feedback(model, frozen, real, MU / h)
    factorise_feedback(model, frozen, pair, NU / h)
    return 3 if again else 2


@inlined
def yield_rows(workspace: RadauWorkspace) -> None:
    """Add e (lambda - lambda_p) to the stage residuals of the constraints."""
    soft, gamma = workspace.frozen.softness, workspace.gamma
    for k in range(3):
        for i in range(soft.shape[0]):
            gamma[k, i] += soft[i] * (workspace.multipliers[k, i] - workspace.predicted[k, i])


@inlined
def reduce_multipliers(model: Model, workspace: RadauWorkspace) -> None:
    """Take out of the multipliers of the stages what has no effect.

    With the softened rows, least multipliers F lambda answer the load Phi_q' lambda, where F is
    s / (s + e) for a combination of rows with the stiffness s. What is taken out is
    (1 - F)^PASSES lambda: all of dependent rows, next to nothing of weak ones.
    """
    real, J, L = workspace.real, workspace.frozen.J, workspace.multipliers
    idle = workspace.predicted  # memory that the next prediction fills
    plan, row_start, body_row = model.plan, model.plan.row_start, model.plan.body_row
    n_c = model.n_constraint
    for k in range(3):
        for i in range(n_c):
            idle[k, i] = L[k, i]
        for _ in range(PASSES):
            real.gamma[:] = 0.0
            real.load[:] = 0.0
            for i in range(plan.size.shape[0]):
                first = row_start[i]
                for p in range(row_start[i + 1] - first):
                    row = body_row[first + p]
                    if row < n_c:
                        for a in range(plan.size[i]):
                            real.load[i, a] += J[i, a, p] * idle[k, row]
            solve(plan, plan.newton, real.factors, real.load, real.gamma, real.x, real.mu)
            for i in range(n_c):
                idle[k, i] -= real.mu[i]
        for i in range(n_c):
            L[k, i] -= idle[k, i]
