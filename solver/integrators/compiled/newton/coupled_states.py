"""Auxiliary states in Newton's matrix, where they belong to a force along a coordinate.

A force -F along a coordinate e may read states z of its own: a bristle, the filter of a controller.
With zdot = phi(e, edot, z), a change x of positions changes the state by

    dz = (r_z + phi_e g x + phi_v (s g x - g rho)) / (s - phi_z),

so that the row of the force (pencil.py) holds k + s c + F_z (phi_e + s phi_v) / (s - phi_z) in
place of k + s c. Other dependence on states is left to the iteration.
"""

from ....dynamics.evaluation.measures import auxiliary_rate
from ....dynamics.model.model import Model
from ....dynamics.model.workspace import Work
from ....math.arrays import Array
from ....math.compiled import inlined, lean
from ....math.expressions.program import NO_SEED, evaluated

OF_FORCE, OF_VALUE, OF_RATE = 0, 1, 2  # F_z, phi_e, phi_v


@lean
def freeze_states(model: Model, work: Work, t: float, auxiliary: Array, coupled: Array) -> None:
    """Fill auxiliary (na,) with phi_z and coupled (n, 3) with F_z, phi_e, phi_v at time t."""
    q = model.quantities
    n = q.kind.shape[0]
    for j in range(model.n_aux):
        _, auxiliary[j] = auxiliary_rate(q, j, t, work.quantity)
    for p in range(q.coupled_force.shape[0]):
        k, j = q.coupled_force[p], q.coupled_state[p]
        of_force = evaluated(q.programs, q.force[k], t, work.quantity, 2 * n + j, NO_SEED, q.stack)
        coupled[p, OF_FORCE] = -of_force[1]
        own = 2 * q.along[k]
        of_state = evaluated(q.programs, q.rate[j], t, work.quantity, own, own + 1, q.stack)
        coupled[p, OF_VALUE], coupled[p, OF_RATE] = of_state[1], of_state[2]


@inlined
def hold_states(
    model: Model,
    auxiliary: Array,
    coupled: Array,
    s: complex,
    stiffness: float,
    first: int,
    hold: Array,
) -> None:
    """Add what states hold to the rows of force elements, from `first` on, times `stiffness`."""
    q = model.quantities
    for p in range(coupled.shape[0]):
        row = first + model.plan.element_start[q.coupled_force[p]]
        moved = coupled[p, OF_VALUE] + s * coupled[p, OF_RATE]
        rate = s - auxiliary[q.coupled_state[p]]
        hold[row] += stiffness * coupled[p, OF_FORCE] * moved / rate


@inlined
def left_of_states(
    model: Model,
    auxiliary: Array,
    coupled: Array,
    J: Array,
    r: Array,
    rho: Array,
    s: complex,
    first: int,
    gamma: Array,
) -> None:
    """Subtract the residuals of the auxiliary states from the rows of force elements in gamma."""
    q = model.quantities
    for p in range(coupled.shape[0]):
        k, j = q.coupled_force[p], q.coupled_state[p]
        row, left = first + model.plan.element_start[k], r[model.n_pos + model.n_vel + j]
        c = coupled[p, OF_FORCE] / (s - auxiliary[j])
        gamma[row] -= c * left
        for side in range(2):
            at = model.plan.element_side[k, side]
            if at >= 0:
                body = model.marker_body[model.force_marker[k, side]]
                for b in range(model.plan.size[body]):
                    gamma[row] += c * coupled[p, OF_RATE] * J[body, b, at] * rho[body, b]


@inlined
def move_states(
    model: Model,
    auxiliary: Array,
    coupled: Array,
    J: Array,
    r: Array,
    rho: Array,
    x: Array,
    s: complex,
    delta: Array,
) -> None:
    """Fill the changes of the states in delta (n,), from the motion x and rho (nb, n)."""
    q, first = model.quantities, model.n_pos + model.n_vel
    for j in range(model.n_aux):
        delta[first + j] = r[first + j] / (s - auxiliary[j])
    for p in range(coupled.shape[0]):
        k, j = q.coupled_force[p], q.coupled_state[p]
        by_x = (coupled[p, OF_VALUE] + s * coupled[p, OF_RATE]) / (s - auxiliary[j])
        by_rho = coupled[p, OF_RATE] / (s - auxiliary[j])
        for side in range(2):
            at = model.plan.element_side[k, side]
            if at >= 0:
                body = model.marker_body[model.force_marker[k, side]]
                for b in range(model.plan.size[body]):
                    moved = by_x * x[body, b] - by_rho * rho[body, b]
                    delta[first + j] += J[body, b, at] * moved
