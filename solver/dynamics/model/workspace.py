"""Memory of one evaluation of the equations of motion: allocated once, filled every time."""

from typing import Any, NamedTuple

import numpy as np

from ...math.arrays import Array
from ...math.compiled import lean, structure
from .model import Model
from .motion import N_MOTION, stand
from .order import Order

# A constraint row: coefficients C of v_1, w_1, v_2, w_2 in global components, then these.
PHI, PHI_T, GAMMA = 12, 13, 14
N_ROW = 15
# A row of a force element (forces/contract.py): coefficients C as above, then these.
STIFFNESS, DAMPING, FORCE = 12, 13, 14
N_ELEMENT_ROW = 15


@structure
class Factors(NamedTuple):
    """Bodies eliminated from [K Phi_q'; Phi_q 0], K of one block per body (elimination.py)."""

    L: Array  # (nb, n, n) unit lower triangles of each body's block
    pivot: Array  # (nb, n) reciprocals of the diagonal
    W: Array  # (nb, n, r) L^-T Phi_q'
    P: Array  # (nb, 7, 6) factors of the rows that drive a frame, and the order of these
    S: Array  # profile of Phi_q K^-1 Phi_q', then its unit lower triangle
    S_pivot: Array  # (n_p,) reciprocals of its diagonal
    regular: Array  # (1,) least pivot over its diagonal entry before elimination
    z: Array  # (nb, n)
    mu: Array  # (n_p,) in the order of elimination


@structure
class Work(NamedTuple):
    """Arrays that an evaluation fills; arrays of bodies have the size of the largest body."""

    A: Array  # (nb, 3, 3) rotation matrices A_GB
    M: Array  # (nb, n, n) mass matrices, lower triangles
    f: Array  # (nb, n) loads, quadratic velocity terms, elastic and damping forces
    J: Array  # (nb, n, r) Jacobian of the rows of plan.mass at each body, transposed
    power: Array  # (2,) of dampers, actuators and loads [W]; energy in force elements [J]
    rows: Array  # (n_c, N_ROW) of the constraints, laid out as above
    # markers (nk)
    motion: Array  # (nk, 24) (dynamics/model/motion.py)
    J_m: Array  # (nk, 6, n) Jacobians of velocity and angular velocity
    # of one body at a time
    D: Array  # (9, m)
    R: Array  # (9, m)
    B: Array  # (3, 3)
    P: Array  # (3, 3)
    # solution
    factors: Factors  # of the mass matrix
    load: Array  # (nb, n) right-hand side
    acceleration: Array  # (nb, n)
    gamma: Array  # (n_c,) right-hand side of the constraint rows
    multipliers: Array  # (n_c,)
    left: Array  # (n_c,) what a solution leaves of gamma
    softness: Array  # (n_r,) of the rows of plan.mass: reciprocals of the penalties in use
    change: Array  # (nb, n) of accelerations and multipliers, where these are iterated
    change_multipliers: Array  # (n_c,)
    # of one body at a time
    C: Array  # (3, m) slope of the first moment of mass by the modes
    first: Array  # (3, 3) first moment of mass, its rate, its second rate at steady modal rates
    twist: Array  # (3,) rate of the moment of momentum in the body at steady modal rates
    # of one force element at a time
    element: Array  # (MOST_ROWS, N_ELEMENT_ROW) all rows that its kind can have
    element_used: Array  # the same of those that it has
    # what expressions read, and what they give
    quantity: (
        Array  # (2 nm + na + nr,) values and rates of coordinates, auxiliary states, reactions
    )
    g: Array  # (nm, 12) rows of the coordinates
    size: Array  # (nf, 3) of force elements, and derivatives by their coordinate and its rate
    unsettled: Array  # (nf + 1, 2) of forces that read reactions (evaluation.py)


def new_factors(model: Model, order: Order, one: Any) -> Factors:
    """Return memory for factors with the rows of `order`, of the type of `one`."""
    nb, n, r = model.n_body, model.plan.widest, order.most_rows
    n_p = order.first.shape[0]
    return Factors(
        np.zeros((nb, n, n)) * one,
        np.zeros((nb, n)) * one,
        np.zeros((nb, n, r)) * one,
        np.zeros((nb, 7, 6)) * one,
        np.zeros(order.profile_start[n_p]) * one,
        np.zeros(n_p) * one,
        np.ones(1),
        np.zeros((nb, n)) * one,
        np.zeros(n_p) * one,
    )


def new_work(model: Model) -> Work:
    """Return the memory for evaluations of a model.

    Ground markers and the rows of added inertia are filled once for all.
    """
    plan = model.plan
    nb, n, r, m = model.n_body, plan.widest, plan.mass.most_rows, plan.most_modes
    n_c, nk = model.n_constraint, model.marker_body.shape[0]
    work = Work(
        np.zeros((nb, 3, 3)),
        np.zeros((nb, n, n)),
        np.zeros((nb, n)),
        np.zeros((nb, n, r)),
        np.zeros(2),
        np.zeros((n_c, N_ROW)),
        np.zeros((nk, N_MOTION)),
        np.zeros((nk, 6, n)),
        np.zeros((9, m)),
        np.zeros((9, m)),
        np.zeros((3, 3)),
        np.zeros((3, 3)),
        new_factors(model, plan.mass, 1.0),
        np.zeros((nb, n)),
        np.zeros((nb, n)),
        np.zeros(n_c),
        np.zeros(n_c),
        np.zeros(n_c),
        np.zeros(plan.mass.place.shape[0]),
        np.zeros((nb, n)),
        np.zeros(n_c),
        np.zeros((3, m)),
        np.zeros((3, 3)),
        np.zeros(3),
        np.zeros((plan.most_element_rows, N_ELEMENT_ROW)),
        np.zeros((plan.most_element_rows, N_ELEMENT_ROW)),
        np.zeros(
            2 * model.quantities.kind.shape[0]
            + model.n_aux
            + model.quantities.reaction_kind.shape[0]
        ),
        np.zeros((model.quantities.kind.shape[0], 12)),
        np.zeros((model.force_kind.shape[0], 3)),
        np.zeros((model.force_kind.shape[0] + 1, 2)),
    )
    for k in range(nk):
        if model.marker_body[k] < 0:
            stand(work.motion[k], model.marker_x[k], model.marker_A[k])
    place_added_rows(model, work.J)
    return work


def spare_work(model: Model) -> Work:
    """Return memory for evaluations that are over when the caller returns.

    One for each plan: models that differ in numbers only share it.
    """
    own = model.marker_x, model.marker_A, model.added_direction  # what `new_work` fills in
    known = model.plan.__dict__.get("_spare")
    if known is None or any(one is not other for one, other in zip(known[0], own, strict=True)):
        known = model.plan.__dict__["_spare"] = own, new_work(model)
    return known[1]  # type: ignore[no-any-return]


@lean
def place_added_rows(model: Model, J: Array) -> None:
    """Fill the columns of J (nb, n, r) that belong to added inertia."""
    plan = model.plan
    for i in range(model.n_body):
        begin = plan.row_start[i + 1] - plan.row_start[i] - plan.added_start[i]
        for a in range(plan.added_start[i], plan.added_start[i + 1]):
            for k in range(plan.size[i]):
                J[i, k, begin + a] = model.added_direction[a, k]
