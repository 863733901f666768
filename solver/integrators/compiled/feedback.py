"""Forces that read other coordinates or reactions, in Newton's matrix.

A force F along a coordinate may follow other coordinates e_m (a controller, an expression), also by
its own states, and the multipliers (friction in a bearing); a load by an expression has no
coordinate of its own and follows others only. Its change

    w(x, mu) = sum (F_e + s F_v) g_m x - F_v g_m rho + F_lambda mu,

with F_z (phi_e + s phi_v) / (s - phi_z) more for each state z of its own, would fill the matrices
and make them unsymmetric. So it is added as a matrix of the rank of the forces that have
it (formula of Woodbury): with the answers (x_k, mu_k) of the pencil to a unit of force k,

    x = x_0 + sum c_k x_k,   c_k = w_k(x_0, mu_0) + sum_j w_k(x_j, mu_j) c_j.

States of its own (a bristle, the filter of a controller): with the force -F along a coordinate e
and zdot = phi(e, edot, z), a change x of positions changes the state by

    dz = (r_z + phi_e g x + phi_v (s g x - g rho)) / (s - phi_z),

so that the row of the force (pencil.py) holds k + s c + F_z (phi_e + s phi_v) / (s - phi_z) in
place of k + s c. Other dependence on states is left to the iteration.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ...dynamics.evaluation.elimination import solve
from ...dynamics.evaluation.laws import auxiliary_rate
from ...dynamics.evaluation.reactions import reaction_slope
from ...dynamics.model.model import Model, Workspace
from ...math.arrays import Array, zeros_of
from ...math.compiled import inlined, lean, structure
from ...math.expressions.program import NO_SEED, evaluated

OF_FORCE, OF_VALUE, OF_RATE = 0, 1, 2  # F_z, phi_e, phi_v
BY_VALUE, BY_RATE = 0, 1


@structure
class Feedback(NamedTuple):
    """Slopes at one place of a step: of states by themselves; of forces by their own states and
    the reverse; of -F of the r forces `feedback`, then of the rates of the states
    `coupled_state`, by other coordinates."""

    auxiliary: Annotated[Array, "na"]  # phi_z [1/s]
    coupled: Annotated[Array, "nz, 3"]  # F_z, phi_e, phi_v
    fed: Annotated[Array, "rows, 2, nb, n"]  # by value and by rate
    by_reactions: Annotated[Array, "r, n_c"]  # by the multipliers


@lean
def freeze_states(model: Model, work: Workspace, t: float, feedback: Feedback) -> None:
    """Fill the slopes of forces by their own states, and of these, at time t.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    feedback : slopes, of which `auxiliary` and `coupled` are filled
    """
    q, auxiliary, coupled = model.quantities, feedback.auxiliary, feedback.coupled
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
    model: Model, feedback: Feedback, s: complex, stiffness: float, first: int, hold: Array
) -> None:
    """Add what states hold to the rows of force elements, from `first` on, times `stiffness`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    feedback : slopes of the forces with feedback, and of their own states
    s : rate per change, of the method over the step size [1/s]
    stiffness : factor of the stiffness in the matrix
    first : first row of the force elements
    hold : stiffness of each row, added to
    """
    q, auxiliary, coupled = model.quantities, feedback.auxiliary, feedback.coupled
    for p in range(coupled.shape[0]):
        row = first + model.layout.element_start[q.coupled_force[p]]
        moved = coupled[p, OF_VALUE] + s * coupled[p, OF_RATE]
        rate = s - auxiliary[q.coupled_state[p]]
        hold[row] += stiffness * coupled[p, OF_FORCE] * moved / rate


@inlined
def left_of_states(
    model: Model, frozen: Any, r: Array, rho: Array, s: complex, first: int, gamma: Array
) -> None:
    """Subtract the residuals of the auxiliary states from the rows of force elements in gamma.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : slopes of the forces with feedback and of their own states, Jacobians of elements
    r : residuals of the rates (n,)
    rho : residuals of positions by bodies (nb, n)
    s : rate per change, of the method over the step size [1/s]
    first : first row of the force elements
    gamma : right-hand sides of the rows (n_r,), changed
    """
    q, feedback, J = model.quantities, frozen.feedback, frozen.J
    auxiliary, coupled = feedback.auxiliary, feedback.coupled
    for p in range(coupled.shape[0]):
        k, j = q.coupled_force[p], q.coupled_state[p]
        row, left = first + model.layout.element_start[k], r[model.n_pos + model.n_vel + j]
        c = coupled[p, OF_FORCE] / (s - auxiliary[j])
        gamma[row] -= c * left
        for side in range(2):
            at = model.layout.element_side[k, side]
            if at >= 0:
                body = model.marker_body[model.force_marker[k, side]]
                for b in range(model.layout.size[body]):
                    gamma[row] += c * coupled[p, OF_RATE] * J[body, b, at] * rho[body, b]


@inlined
def move_states(
    model: Model, frozen: Any, r: Array, rho: Array, x: Array, s: complex, delta: Array
) -> None:
    """Fill the changes of the states in delta (n,), from the motion x and rho (nb, n).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : slopes of the forces with feedback and of their own states, Jacobians of elements
    r : residuals of the rates (n,)
    rho : residuals of positions by bodies (nb, n)
    x : change of positions by bodies (nb, n)
    s : rate per change, of the method over the step size [1/s]
    delta : change of the state (n,), filled at the auxiliary states
    """
    q, first = model.quantities, model.n_pos + model.n_vel
    feedback, J = frozen.feedback, frozen.J
    auxiliary, coupled = feedback.auxiliary, feedback.coupled
    for j in range(model.n_aux):
        delta[first + j] = r[first + j] / (s - auxiliary[j])
    for p in range(coupled.shape[0]):
        k, j = q.coupled_force[p], q.coupled_state[p]
        by_x = (coupled[p, OF_VALUE] + s * coupled[p, OF_RATE]) / (s - auxiliary[j])
        by_rho = coupled[p, OF_RATE] / (s - auxiliary[j])
        for side in range(2):
            at = model.layout.element_side[k, side]
            if at >= 0:
                body = model.marker_body[model.force_marker[k, side]]
                for b in range(model.layout.size[body]):
                    moved = by_x * x[body, b] - by_rho * rho[body, b]
                    delta[first + j] += J[body, b, at] * moved


@structure
class Answers(NamedTuple):
    """Answers of a pencil to a unit of each force with feedback."""

    x: Array  # (r, nb, n)
    mu: Array  # (r, n_r)
    inverse: Array  # (r, 2 r) right half: inverse of 1 - w_k(x_j)
    change: Array  # (r,)


def new_feedback(model: Model) -> Feedback:
    """Return memory."""
    r, nz = model.quantities.feedback.shape[0], model.quantities.coupled_force.shape[0]
    sizes = {"na": model.n_aux, "nz": nz, "rows": r + nz if r else 0, "r": r}
    sizes |= {"nb": model.n_body, "n": model.layout.widest, "n_c": model.n_constraint}
    return zeros_of(Feedback, sizes)


def new_answers(model: Model, one: Any) -> Answers:
    """Return memory of the type of `one`."""
    r, n_r = model.quantities.feedback.shape[0], model.layout.newton.place.shape[0]
    return Answers(
        np.zeros((r, model.n_body, model.layout.widest)) * one,
        np.zeros((r, n_r)) * one,
        np.zeros((r, 2 * r)) * one,
        np.zeros(r) * one,
    )


@lean
def freeze_feedback(model: Model, work: Workspace, t: float, feedback: Feedback) -> None:
    """Fill the slopes at the last evaluation, at time t.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    feedback : slopes of the forces with feedback
    """
    q, fed, by_reactions = model.quantities, feedback.fed, feedback.by_reactions
    n_force = q.feedback.shape[0]
    fed[:] = 0.0
    by_reactions[:] = 0.0
    for i in range(q.fed_row.shape[0]):
        row, m = q.fed_row[i], q.fed_coordinate[i]
        if row < n_force:
            p, sign = q.force[q.feedback[row]], -1.0
        else:
            p, sign = q.rate[q.coupled_state[row - n_force]], 1.0
        value = evaluated(q.programs, p, t, work.quantity, 2 * m, 2 * m + 1, q.stack)
        for side in range(2):
            marker = q.marker[m, side]
            body = model.marker_body[marker]
            if body >= 0:
                for b in range(model.layout.size[body]):
                    moved = 0.0
                    for a in range(6):
                        moved += work.g[m, 6 * side + a] * work.J_m[marker, a, b]
                    fed[row, BY_VALUE, body, b] += sign * value[1] * moved
                    fed[row, BY_RATE, body, b] += sign * value[2] * moved
    first = work.quantity.shape[0] - q.reaction_kind.shape[0]
    for i in range(n_force):
        p = q.force[q.feedback[i]]
        for r in range(q.reaction_kind.shape[0]):
            value = evaluated(q.programs, p, t, work.quantity, first + r, NO_SEED, q.stack)
            if value[1] != 0.0:
                joint = q.reaction_joint[r]
                for row in range(model.joint_row[joint], model.joint_row[joint + 1]):
                    by_reactions[i, row] -= value[1] * reaction_slope(model, work, r, row)


@lean
def scale_feedback(feedback: Feedback, factor: float) -> None:
    """Multiply the slopes by coordinates, for a pencil that is multiplied by `factor`.

    Multipliers are those of that pencil: slopes by reactions stay.
    """
    fed = feedback.fed
    for i in range(fed.shape[0]):
        for j in range(fed.shape[1]):
            for k in range(fed.shape[2]):
                for b in range(fed.shape[3]):
                    fed[i, j, k, b] *= factor


@inlined
def followed(s: complex, of: Array, x: Array, rho: Array, lagging: float) -> complex:
    """Return (by value + s by rate) x - lagging by rate rho of one row of `fed`.

    Parameters
    ----------
    s : rate per change, of the method over the step size [1/s]
    of : one row of `fed`: derivatives by value and by rate (2, nb, n)
    x : change of positions by bodies (nb, n)
    rho : residuals of positions by bodies (nb, n)
    lagging : factor of rho, 0 or 1
    """
    total = 0.0 * s
    for i in range(x.shape[0]):
        for b in range(x.shape[1]):
            a, c = of[BY_VALUE, i, b], of[BY_RATE, i, b]
            if a != 0.0 or c != 0.0:
                total += (a + s * c) * x[i, b] - lagging * c * rho[i, b]
    return total


@inlined
def change_of_force(
    model: Model,
    feedback: Feedback,
    i: int,
    s: complex,
    x: Array,
    rho: Array,
    lagging: float,
    mu: Array,
) -> complex:
    """Return w of feedback i.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    feedback : slopes of the forces with feedback
    i : number of the feedback
    s : rate per change, of the method over the step size [1/s]
    x : change of positions by bodies (nb, n)
    rho : residuals of positions by bodies (nb, n)
    lagging : factor of rho, 0 or 1
    mu : changes of multipliers and element forces (n_r,)
    """
    q, fed = model.quantities, feedback.fed
    total = followed(s, fed[i], x, rho, lagging)
    for row in range(feedback.by_reactions.shape[1]):
        total += feedback.by_reactions[i, row] * mu[row]
    for p in range(q.coupled_force.shape[0]):
        if q.coupled_force[p] == q.feedback[i]:
            moved = followed(s, fed[q.feedback.shape[0] + p], x, rho, lagging)
            rate = s - feedback.auxiliary[q.coupled_state[p]]
            total += feedback.coupled[p, OF_FORCE] * moved / rate
    return total


@lean
def answer_forces(model: Model, pencil: Any, feedback: Feedback, s: complex) -> None:
    """Fill the answers of a factorised pencil to the forces with feedback; load, gamma get 0.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    pencil : factorised matrix and its memory
    feedback : slopes of the forces with feedback
    s : rate per change, of the method over the step size [1/s]
    """
    load, gamma, softness, answers = pencil.load, pencil.gamma, pencil.softness, pencil.answers
    q, layout = model.quantities, model.layout
    n = q.feedback.shape[0]
    first = model.n_constraint + layout.added_start[model.n_body]
    load[:] = 0.0
    for i in range(n):
        row = first + layout.element_start[q.feedback[i]]
        gamma[:] = 0.0
        gamma[row] = -softness[row]
        solve(layout, layout.newton, pencil.factors, load, gamma, answers.x[i], answers.mu[i])
    gamma[:] = 0.0
    both = answers.inverse
    both[:] = 0.0
    for i in range(n):
        for j in range(n):
            x, mu = answers.x[j], answers.mu[j]
            w = change_of_force(model, feedback, i, s, x, x, 0.0, mu)
            both[i, j] = -w
        both[i, i] += 1.0
        both[i, n + i] = 1.0
    _invert(both)


@lean
def add_feedback(
    model: Model, feedback: Feedback, s: complex, answers: Answers, x: Array, rho: Array, mu: Array
) -> None:
    """Add what forces with feedback do to the answer x (nb, n), mu (n_r,) of a pencil.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    feedback : slopes of the forces with feedback
    s : rate per change, of the method over the step size [1/s]
    answers : answers to a unit of each force
    x : answer by bodies (nb, n), changed
    rho : residuals of positions by bodies (nb, n)
    mu : multipliers and element forces (n_r,), changed
    """
    n = model.quantities.feedback.shape[0]
    for i in range(n):
        answers.change[i] = change_of_force(model, feedback, i, s, x, rho, 1.0, mu)
    for i in range(n):
        c = 0.0 * s
        for j in range(n):
            c += answers.inverse[i, n + j] * answers.change[j]
        for body in range(x.shape[0]):
            for b in range(x.shape[1]):
                x[body, b] += c * answers.x[i, body, b]
        for row in range(mu.shape[0]):
            mu[row] += c * answers.mu[i, row]


@lean
def move_fed_states(
    model: Model, feedback: Feedback, s: complex, x: Array, rho: Array, delta: Array
) -> None:
    """Add to delta (n,) what states follow of coordinates other than their force's own.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    feedback : slopes of the forces with feedback
    s : rate per change, of the method over the step size [1/s]
    x : change of positions by bodies (nb, n)
    rho : residuals of positions by bodies (nb, n)
    delta : change of the state (n,), added to
    """
    q, first = model.quantities, model.n_pos + model.n_vel
    for p in range(q.coupled_force.shape[0]):
        j = q.coupled_state[p]
        moved = followed(s, feedback.fed[q.feedback.shape[0] + p], x, rho, 1.0)
        delta[first + j] += moved / (s - feedback.auxiliary[j])


@lean
def _invert(both: Array) -> None:
    """Reduce [A 1] (n, 2 n) to [1 A^-1]; not-a-number where A has no inverse."""
    n = both.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(both[i, k]) > abs(both[best, k]):
                best = i
        for j in range(2 * n):
            both[k, j], both[best, j] = both[best, j], both[k, j]
        d = both[k, k]
        for j in range(2 * n):
            both[k, j] = both[k, j] / d if abs(d) > 0.0 else np.nan
        for i in range(n):
            c = both[i, k]
            if i != k and abs(c) > 0.0:
                for j in range(2 * n):
                    both[i, j] -= c * both[k, j]
