"""Solution of M a + Phi_q' lambda = f, Phi_q a = gamma by elimination of the bodies."""

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ..elements.block_vectors import row_products
from ..model.model import Model
from ..model.workspace import Work
from .dependence import REGULAR, rows_depend
from .elimination import factorise, solve


@inlined
def factorise_mass(model: Model, work: Work) -> None:
    """Factorise the mass matrix of the last evaluation with its constraints.

    If constraint rows are dependent, or nearly so, the penalty of the augmented
    Lagrangian is used, if the treatment has one: 1 / penalty on the diagonal of S, divided by the
    effective mass of the row.
    """
    work.softness[:] = 0.0
    _factorise_blocks(model, work)
    if model.penalty > 0.0 and work.factors.regular[0] < REGULAR:
        depend = rows_depend(model, model.plan.mass, work.factors, work.J, work.softness)
        work.softness[:] = 0.0
        if depend:
            soften(model, work.J, work.softness)
        _factorise_blocks(model, work)


@lean
def soften(model: Model, J: Array, softness: Array) -> None:
    """Fill softness of constraints: 1 / penalty, over the mass that each row of J (nb, n, r) moves.

    Softness (n_r,) of other rows is left alone.
    """
    plan = model.plan
    for k in range(model.n_constraint):
        softness[k] = 0.0
    for i in range(model.n_body):
        v, first = model.vel_start[i], plan.row_start[i]
        for p in range(plan.row_start[i + 1] - first):
            mobility = 0.0
            for k in range(plan.size[i]):
                mobility += J[i, k, p] ** 2 / model.inertia_scale[v + k]
            softness[plan.body_row[first + p]] += mobility
    for k in range(model.n_constraint):
        softness[k] = (softness[k] if softness[k] > 0.0 else 1.0) / model.penalty


@inlined
def _factorise_blocks(model: Model, work: Work) -> None:
    for i in range(model.n_body):
        n = model.plan.size[i]
        for a in range(n):
            for b in range(a + 1):
                work.factors.L[i, a, b] = work.M[i, a, b]
        add_inertia(model, i, 1.0, work.factors.L[i], work.softness)
    factorise(model.plan, model.plan.mass, work.factors, work.J, work.softness)


@inlined
def add_inertia(model: Model, i: int, mass: complex, L: Array, softness: Array) -> None:
    """Add what body i has of added inertia, times `mass`, to L (n, n), and fill its rows' softness.

    Softness is that of the rows of either order of the plan.
    """
    for a in range(model.plan.added_start[i], model.plan.added_start[i + 1]):
        sigma, g = mass * model.added_inertia[a], model.added_direction[a]
        for k in range(model.plan.size[i]):
            for j in range(k + 1):
                L[k, j] += sigma * g[k] * g[j]
        softness[model.n_constraint + a] = -1.0 / sigma


@inlined
def solve_mass(model: Model, work: Work) -> None:
    """Fill work.acceleration and multipliers with the solution for work.load and work.gamma.

    After `factorise_mass`. With a penalty in use the multipliers are iterated,
    lambda += (S + 1/P)^-1 (Phi_q a - gamma): Bayo's augmented Lagrangian
    (constraints/augmented_lagrangian.py), written for the multipliers. Multipliers of redundant
    rows have least norm.
    """
    a, left = work.acceleration, work.left
    plan = model.plan
    solve(plan, plan.mass, work.factors, work.load, work.gamma, a, work.multipliers)
    if model.n_constraint == 0 or not work.softness[0] > 0.0:
        return
    change, multipliers = work.change, work.change_multipliers
    work.load[:] = 0.0
    for _ in range(model.multiplier_iterations):
        row_products(model, work.J, a, left)
        for k in range(left.shape[0]):
            left[k] = work.gamma[k] - left[k]
        solve(plan, plan.mass, work.factors, work.load, left, change, multipliers)
        for k in range(left.shape[0]):
            work.multipliers[k] += multipliers[k]
        size, whole = 0.0, 0.0
        for i in range(model.n_body):
            v = model.vel_start[i]
            for k in range(model.plan.size[i]):
                a[i, k] += change[i, k]
                size += model.inertia_scale[v + k] * change[i, k] ** 2
                whole += model.inertia_scale[v + k] * a[i, k] ** 2
        if size <= model.multiplier_tolerance**2 * whole:
            break
