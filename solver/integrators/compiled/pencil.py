"""Newton's matrix of an implicit step, with the structure of a mechanism.

Of the derivatives of the equations only what can be stiff is kept: stiffness K and damping D of
the modes, that of rotations by tension (tension.py) in K where it is in use, and those of the force
elements, sum g'(k + s c) g. With a rate of s per change
(s = gamma / h, real or complex), a change x of positions along the velocity coordinates, delta v
of velocities and mu of multipliers answers residuals

    R = f - M vdot - Phi_q' lambda,   c = gamma - Phi_q vdot,   rho = G^+ (G v - qdot)

by one system of the same structure as that of the mass matrix:

    (s^2 M + s D + K) x + Phi_q' mu + g' m = R + s M rho + D rho,
    Phi_q x = (c + (s + 2 alpha) Phi_q rho) / (s^2 + 2 alpha s + beta^2),
    g x - m / (k + s c) = (e + c g rho) / (k + s c),
    delta v = s x - rho,   delta q = G x + (r_q - G rho) / s,
    delta z of auxiliary states as in feedback.py,

with the feedback alpha, beta of Baumgarte's treatment in c: without it in the matrix, Newton's
iteration would converge only where steps are much shorter than 1 / alpha and 1 / beta. Forces of
elements are unknowns of the iteration like multipliers, m being their change and e the residual
of the law of the element (elements.py): an element as stiff as a constraint is a constraint
to it.
"""

from typing import Annotated, Any, NamedTuple

from ...dynamics.evaluation.accelerations import add_inertia, soften
from ...dynamics.evaluation.elimination import factorise, rows_depend, solve
from ...dynamics.model.model import (
    Factors,
    Model,
    Workspace,
    new_factors,
    place_added_rows,
    state_size,
)
from ...dynamics.tolerances import REGULAR
from ...math.arrays import Array, zeros_of
from ...math.compiled import inlined, lean, structure
from ...math.rotations import along_parameters
from .feedback import (
    Answers,
    Feedback,
    add_feedback,
    answer_forces,
    freeze_feedback,
    freeze_states,
    hold_states,
    left_of_states,
    move_fed_states,
    move_states,
    new_answers,
    new_feedback,
)
from .residual import freeze_elements
from .tension import add_tension

NOTHING = 1e-100  # of stiffness and damping: an element that holds nothing in a direction


@structure
class Pencil(NamedTuple):
    """Factors for one s, and a right-hand side with its answer."""

    factors: Factors
    load: Annotated[Array, "nb, widest"]  # R
    # c of constraints and e of force elements; afterwards 0 beyond constraints
    gamma: Annotated[Array, "n_r"]
    r: Annotated[Array, "n"]  # r_q and r_z
    rho: Annotated[Array, "nb, widest"]
    x: Annotated[Array, "nb, widest"]
    delta: Annotated[Array, "n"]  # answer in the coordinates of y
    mu: Annotated[Array, "n_r"]
    softness: Annotated[Array, "n_r"]  # of the rows of layout.newton
    answers: Answers  # to forces that read other coordinates (feedback.py)


@structure
class Frozen(NamedTuple):
    """Mass matrix, Jacobian, stiffness of elements and Euler parameters at one place of a step."""

    M: Annotated[Array, "nb, n, n"]  # lower triangles
    J: Annotated[Array, "nb, n, r"]  # of the rows of layout.newton
    softness: Annotated[Array, "n_c"]  # of constraints
    p: Annotated[Array, "nb, 4"]
    stiffness: Annotated[Array, "n_e"]  # of the rows of force elements [N/m, N m/rad]
    damping: Annotated[Array, "n_e"]  # [N s/m, N m s/rad]
    feedback: Feedback
    # of rotations and modes, lower triangles; 0: not in use (tension.py)
    tension: Annotated[Array, "nb, n, n"]


def new_pencil(model: Model, one: Any) -> Pencil:
    """Return memory of the type of `one`."""
    nb, n, n_r = model.n_body, model.layout.widest, model.layout.newton.place.shape[0]
    n_y = state_size(model)
    sizes = {"nb": nb, "widest": n, "n_r": n_r, "n": n_y}
    factors, answers = new_factors(model, model.layout.newton, one), new_answers(model, one)
    return zeros_of(Pencil, sizes, one, factors=factors, answers=answers)


def new_frozen(model: Model) -> Frozen:
    """Return memory; the rows of added inertia are filled once for all."""
    layout = model.layout
    nb, n, n_e = model.n_body, layout.widest, layout.element_row.shape[0]
    sizes = {"nb": nb, "n": n, "n_e": n_e, "r": layout.newton.most_rows}
    frozen = zeros_of(Frozen, sizes | {"n_c": model.n_constraint}, feedback=new_feedback(model))
    place_added_rows(model, frozen.J)
    return frozen


@inlined
def freeze(model: Model, work: Workspace, t: float, y: Array, frozen: Frozen) -> None:
    """Keep what the last evaluation, at time t in state y, has filled.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    frozen : matrices, to fill
    """
    layout, row_start = model.layout, model.layout.row_start
    frozen.softness[:] = 0.0
    for i in range(layout.size.shape[0]):
        n, r = layout.size[i], row_start[i + 1] - row_start[i]
        M, J, M_0, J_0 = work.M[i], work.J[i], frozen.M[i], frozen.J[i]
        for a in range(n):
            M_0[a, a] = M[a, a]
            for b in range(min(a, layout.lead[i])):
                M_0[a, b] = M[a, b]
            for p in range(r):
                J_0[a, p] = J[a, p]
        for k in range(4):
            frozen.p[i, k] = y[model.pos_start[i] + 3 + k]
    if layout.element_row.shape[0] > 0:
        freeze_elements(model, work, frozen.stiffness, frozen.damping, frozen.J)
    if model.n_aux > 0:
        freeze_states(model, work, t, frozen.feedback)
    if model.quantities.feedback.shape[0] > 0:
        freeze_feedback(model, work, t, frozen.feedback)


@lean
def factorise_pencil(
    model: Model, frozen: Frozen, pencil: Pencil, mass: complex, damping: complex, stiffness: float
) -> None:
    """Factorise mass M + damping D + stiffness K, of modes and elements, with the constraints.

    Rows that depend on each other are softened as in `factorise_mass` (mass_solution.py).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : matrices of the last evaluation that Newton's matrix uses
    pencil : factors and memory, to fill
    mass : factor of M
    damping : factor of D
    stiffness : factor of K
    """
    _factorise(model, frozen, pencil, mass, damping, stiffness)
    if model.penalty > 0.0 and pencil.factors.regular[0] < REGULAR:
        if rows_depend(model, model.layout.newton, pencil.factors, frozen.J, pencil.softness):
            soften(model, frozen.J, frozen.softness)
        _factorise(model, frozen, pencil, mass, damping, stiffness)


@inlined
def _factorise(
    model: Model, frozen: Frozen, pencil: Pencil, mass: complex, damping: complex, stiffness: float
) -> None:
    layout, softness, n_c = model.layout, pencil.softness, model.n_constraint
    for i in range(layout.size.shape[0]):
        n, m, two = layout.size[i], model.n_mode[i], model.square_start[i]
        L, M = pencil.factors.L[i], frozen.M[i]
        for a in range(n):
            L[a, a] = mass * M[a, a]
            for b in range(min(a, layout.lead[i])):
                L[a, b] = mass * M[a, b]
        for a in range(m):
            for b in range(0 if layout.lead[i] > 6 else a, a + 1):
                k = two + a * m + b
                L[6 + a, 6 + b] += stiffness * model.K_qq[k] + damping * model.D_qq[k]
        s_squared = abs(mass / stiffness)
        add_tension(frozen.tension[i], M, n, layout.lead[i], s_squared, stiffness, L)
        add_inertia(model, i, mass, L, softness)
    fed = mass + 2.0 * model.alpha * damping + model.beta**2 * stiffness
    for k in range(n_c):
        softness[k] = frozen.softness[k] / fed
    first = n_c + layout.added_start[model.n_body]
    for k in range(frozen.stiffness.shape[0]):
        softness[first + k] = stiffness * frozen.stiffness[k] + damping * frozen.damping[k]
    s = damping / stiffness if abs(damping) > 0.0 else abs(mass / stiffness) ** 0.5
    hold_states(model, frozen.feedback, s, stiffness, first, softness)
    for k in range(first, first + frozen.stiffness.shape[0]):
        hold = softness[k]
        softness[k] = 1.0 / hold if abs(hold) > NOTHING else 1.0 / NOTHING
    factorise(layout, layout.newton, pencil.factors, frozen.J, softness)


@inlined
def factorise_feedback(model: Model, frozen: Frozen, pencil: Pencil, s: complex) -> None:
    """Answer the forces with feedback, after `factorise_pencil` with mass s^2 and damping s.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : matrices of the last evaluation that Newton's matrix uses
    pencil : factorised matrix
    s : rate per change, of the method over the step size [1/s]
    """
    if model.quantities.feedback.shape[0] > 0:
        answer_forces(model, pencil, frozen.feedback, s)


@inlined
def fed_back(
    model: Model, frozen: Frozen, pencil: Pencil, s: complex, x: Array, rho: Array
) -> None:
    """Add what forces with feedback do to the answer x (nb, n) and pencil.mu of the pencil.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : matrices of the last evaluation that Newton's matrix uses
    pencil : factorised matrix
    s : rate per change, of the method over the step size [1/s]
    x : answer by bodies (nb, n), changed
    rho : residuals of positions by bodies (nb, n)
    """
    add_feedback(model, frozen.feedback, s, pencil.answers, x, rho, pencil.mu)


@lean
def solve_pencil(model: Model, frozen: Frozen, pencil: Pencil, s: complex) -> None:
    """Fill pencil.delta (n,) and mu (n_c,) with the answer to load, gamma and r.

    After `factorise_feedback` with the same s.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    frozen : matrices of the last evaluation that Newton's matrix uses
    pencil : factorised matrix with right-hand sides load, gamma and r
    s : rate per change, of the method over the step size [1/s]
    """
    load, rho, x, delta = pencil.load, pencil.rho, pencil.x, pencil.delta
    gamma, r = pencil.gamma, pencil.r
    n_pos, layout = model.n_pos, model.layout
    row_start, body_row = layout.row_start, layout.body_row
    fed = s + 2.0 * model.alpha
    n_c = model.n_constraint
    e = n_c + layout.added_start[model.n_body]  # first row of the force elements
    for i in range(layout.size.shape[0]):
        n, m, two = layout.size[i], model.n_mode[i], model.square_start[i]
        a = model.pos_start[i]
        spin_of(frozen.p[i], r, a + 3, rho[i])
        for k in range(3):
            rho[i, k] = r[a + k]
        for k in range(m):
            rho[i, 6 + k] = r[a + 7 + k]
        M, J, first = frozen.M[i], frozen.J[i], row_start[i]
        count = row_start[i + 1] - first
        for k in range(n):
            z = s * rho[i, k]
            w = load[i, k] + M[k, k] * z
            for b in range(min(k, layout.lead[i])):
                w += M[k, b] * s * rho[i, b]
                load[i, b] += M[k, b] * z
            load[i, k] = w
            for p in range(count):
                gamma[body_row[first + p]] += J[k, p] * fed * rho[i, k]
        for k in range(m):
            w = load[i, 6 + k]
            for b in range(m):
                w += model.D_qq[two + k * m + b] * rho[i, 6 + b]
            load[i, 6 + k] = w
    c = 1.0 / (s * s + 2.0 * model.alpha * s + model.beta**2)
    for k in range(n_c):
        gamma[k] *= c
    for k in range(model.force_kind.shape[0]):
        begin, end = layout.element_start[k], layout.element_start[k + 1]
        for side in range(2):
            first = layout.element_side[k, side]
            if first >= 0:
                body = model.marker_body[model.force_marker[k, side]]
                J = frozen.J[body]
                for p in range(end - begin):
                    for b in range(layout.size[body]):
                        lost = frozen.damping[begin + p] * rho[body, b]
                        gamma[e + begin + p] += J[b, first + p] * lost
    left_of_states(model, frozen, r, rho, s, e, gamma)
    for k in range(frozen.damping.shape[0]):
        gamma[e + k] *= pencil.softness[e + k]
    solve(layout, layout.newton, pencil.factors, load, gamma, x, pencil.mu)
    for k in range(n_c, gamma.shape[0]):
        gamma[k] = 0.0
    feeds = model.quantities.feedback.shape[0] > 0
    if feeds:
        fed_back(model, frozen, pencil, s, x, rho)
    move_states(model, frozen, r, rho, x, s, delta)
    if feeds:
        move_fed_states(model, frozen.feedback, s, x, rho, delta)
    c = 1.0 / s
    for i in range(layout.size.shape[0]):
        m = model.n_mode[i]
        a, j = model.pos_start[i], n_pos + model.vel_start[i]
        for k in range(layout.size[i]):
            delta[j + k] = s * x[i, k] - rho[i, k]
        for k in range(3):
            delta[a + k] = x[i, k]
        for k in range(m):
            delta[a + 7 + k] = x[i, 6 + k]
        for k in range(3):
            x[i, 3 + k] -= rho[i, 3 + k] * c
        # E x / 2: the change of Euler parameters by a small rotation
        turned = along_parameters(frozen.p[i], 0, 0.5 * x[i, 3], 0.5 * x[i, 4], 0.5 * x[i, 5])
        for k in range(4):
            delta[a + 3 + k] = turned[k] + r[a + 3 + k] * c


@inlined
def spin_of(p: Array, r: Array, a: int, rho: Array) -> None:
    """rho[3:6] = 2 E' r[a:a+4] / p'p: the rotation that changes Euler parameters so.

    Parameters
    ----------
    p : Euler parameters of the matrices (4,)
    r : array with changes of Euler parameters
    a : place of the first one
    rho : array (6,); the last three are filled [rad]
    """
    e0, e1, e2, e3 = p[0], p[1], p[2], p[3]
    c = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    r0, r1, r2, r3 = r[a], r[a + 1], r[a + 2], r[a + 3]
    rho[3] = c * (-e1 * r0 + e0 * r1 + e3 * r2 - e2 * r3)
    rho[4] = c * (-e2 * r0 - e3 * r1 + e0 * r2 + e1 * r3)
    rho[5] = c * (-e3 * r0 + e2 * r1 - e1 * r2 + e0 * r3)
