"""Vectors of all velocities and of each body, and products with the constraint Jacobian."""

from ...math.arrays import Array
from ...math.compiled import inlined, lean
from ..model.model import Model


@inlined
def row_products(model: Model, J: Array, a: Array, out: Array) -> None:
    """Fill out (n_c,) with Phi_q a, for J (nb, n, r) and a (nb, n)."""
    plan = model.plan
    out[:] = 0.0
    for i in range(plan.size.shape[0]):
        first = plan.row_start[i]
        for p in range(plan.row_start[i + 1] - first):
            row = plan.body_row[first + p]
            for j in range(plan.size[i]):
                out[row] += J[i, j, p] * a[i, j]


@inlined
def flatten(model: Model, x: Array, out: Array, first: int) -> None:
    """Fill out from `first` on with x (nb, n), body after body: n_vel numbers."""
    for i in range(model.n_body):
        j = first + model.vel_start[i]
        for k in range(model.plan.size[i]):
            out[j + k] = x[i, k]


@inlined
def inflate(model: Model, a: Array, first: int, x: Array) -> None:
    """Fill x (nb, n) with n_vel numbers of a, from `first` on."""
    for i in range(model.n_body):
        j = first + model.vel_start[i]
        for k in range(model.plan.size[i]):
            x[i, k] = a[j + k]


@lean
def largest(a: Array) -> float:
    """Return the largest absolute value of a; nan if there is one."""
    found = 0.0
    for x in a:
        if abs(x) > found or x != x:
            found = abs(x)
    return found
