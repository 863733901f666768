"""Stiffness that forces give to rotations and modes of a body: that of a taut cable.

A force f that acts at x on a body, from its mass centre and in body axes, has a moment that a
small rotation phi of the body changes by -((x . f) I - f x') phi. Summed over a body,

    K = tr(T) I - T,   T = sum f x',

has no part of the point from which x is measured where the forces balance each other, as they do
on a light body. Light links that carry a heavy load vibrate across it at high frequencies by this
stiffness; without it in the matrix, Newton's iteration converges only where steps resolve these
vibrations. The inertia of the body itself, and its weight, have no part in K: they act at the mass
centre. Modes of a stiffened body (bodies/second_order.py) displace x by J of the slope H: they
have -sum f H, and f~ J with the rotation. Those of a linear body have neither: f~ J alone makes
the block of the body indefinite.

T is symmetric where moments balance each other. Forces of a prediction do not quite, and along a
thin rod, about which nothing resists, the difference would be large beside the inertia: of T_ab
and T_ba the smaller is taken, none if they differ in sign. Left out are forces that turn with the
body (of a slot on its guide, following loads), and changes of the direction of a rod or spring.

K is in use while the run advances faster with it: `judge`.
"""

from typing import Any

from ...dynamics.elements.forces.table import FIRST_LOAD
from ...dynamics.evaluation.evaluation import force_wrench, n_coupling
from ...dynamics.model.model import Model, Workspace
from ...dynamics.model.motion import place
from ...math.arrays import Array, Triple
from ...math.compiled import inlined, lean
from ...math.rotations import column, cross3, turned_back
from .residual import element_rows_at
from .step_control import OTHER, REFUSALS, SINCE, TENSE, TIME, TRIED

# Of the inertia times s^2: less stiffness does not delay Newton's iteration; it may stop it.
FAINT, TAUT = 1e-2, 0.1
# Attempts over which a matrix is judged; share of them that Newton's iteration refuses where it
# limits all steps, which grow to the limit again in six or seven; how many times the other matrix
# has to be faster, per attempt, to be tried again.
WINDOW, SHARE, FASTER = 50.0, 0.13, 2.0


@lean
def freeze_tension(
    model: Model, work: Workspace, t: float, y: Array, forces: Array, tension: Array
) -> None:
    """Fill the lower triangles of tension (nb, n, n) after an evaluation at t in state y (n,).

    `forces` (n_r,) are multipliers of constraints and forces of elements, by row of layout.newton.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    forces : multipliers of constraints and forces of elements (n_r,), by row of layout.newton
    tension : stiffness by tension by bodies (nb, n, n), lower triangles, to fill
    """
    tension[:] = 0.0
    for k in range(model.joint_kind.shape[0] - n_coupling(model)):
        begin, end = model.joint_row[k], model.joint_row[k + 1]
        rows, push = work.rows[begin:end], forces[begin:end]
        for side in range(2):
            _push(model, work, y, model.joint_marker[k, side], side, rows, push, tension)
    first = model.n_constraint + model.layout.added_start[model.n_body]
    for e in range(model.force_kind.shape[0]):
        if model.force_kind[e] >= FIRST_LOAD:
            if model.marker_body[model.force_marker[e, 0]] < 0:
                f = force_wrench(model, work, e, t).force
                _pull(model, work, y, model.force_marker[e, 1], f, tension)
            continue
        count, begin = element_rows_at(model, work, e), first + model.layout.element_start[e]
        rows, push = work.element_used[:count], forces[begin : begin + count]
        for side in range(2):
            _push(model, work, y, model.force_marker[e, side], side, rows, push, tension)
    for i in range(model.n_body):
        _from_virial(tension[i, 3:6, 3:6])


@inlined
def _push(
    model: Model,
    work: Workspace,
    y: Array,
    marker: int,
    side: int,
    rows: Array,
    push: Array,
    tension: Array,
) -> None:
    """Add the forces -rows' push at a marker, without those that turn with it."""
    f = (0.0, 0.0, 0.0)
    for p in range(rows.shape[0]):
        C = rows[p, 6 * side : 6 * side + 6]
        if C[3] == 0.0 and C[4] == 0.0 and C[5] == 0.0:
            f = f[0] - C[0] * push[p], f[1] - C[1] * push[p], f[2] - C[2] * push[p]
    if model.marker_body[marker] >= 0:
        _pull(model, work, y, marker, f, tension)


@lean
def _pull(
    model: Model, work: Workspace, y: Array, marker: int, f_G: Triple, tension: Array
) -> None:
    """Add a force f_G [N], global components, at a marker: f x' in T, and its part in modes."""
    i = model.marker_body[marker]
    x, a, A, M, T = place(work.motion[marker]), model.pos_start[i], work.A[i], work.M[i], tension[i]
    f = turned_back(A, f_G)
    # the block of spins and velocities is m c~ A'; a body without mass has none
    mass = M[0, 0] if M[0, 0] > 0.0 else 1.0
    x_B = turned_back(A, (x[0] - y[a], x[1] - y[a + 1], x[2] - y[a + 2]))
    for q in range(3):
        r, s = (q + 1) % 3, (q + 2) % 3
        c = (M[3 + s, 0] * A[0, r] + M[3 + s, 1] * A[1, r] + M[3 + s, 2] * A[2, r]) / mass
        for b in range(3):
            T[3 + b, 3 + q] += f[b] * (x_B[q] - c)
    m, h, J = model.n_mode[i], model.marker_second[marker], work.J_m[marker]
    for k in range(m if h >= 0 else 0):
        slope = turned_back(A, column(J, 6 + k))
        turn = cross3(f, slope)
        for b in range(3):
            T[6 + k, 3 + b] += turn[b]
        for b in range(3):
            if model.marker_H_used[marker][b]:
                for j in range(k + 1):
                    T[6 + k, 6 + j] -= f[b] * model.marker_H[h + (b * m + k) * m + j]


@inlined
def _from_virial(T: Array) -> None:
    """Replace T (3, 3) by K."""
    trace = T[0, 0] + T[1, 1] + T[2, 2]
    for a in range(3):
        for b in range(a):
            one, two = T[a, b], T[b, a]
            smaller = one if abs(one) < abs(two) else two
            T[a, b] = T[b, a] = -smaller if one * two > 0.0 else 0.0
        T[a, a] = trace - T[a, a]


@inlined
def add_tension(
    K: Array, M: Array, n: int, lead: int, s_squared: float, stiffness: float, L: Array
) -> None:
    """Add K (n, n) of one body, times stiffness, to its L (n, n), unless faint beside s^2 M.

    Parameters
    ----------
    K : stiffness by tension of one body (n, n)
    M : its mass matrix (n, n)
    n : number of its velocities
    lead : number of coordinates that are coupled with all others
    s_squared : factor of M [1/s2]
    stiffness : factor of K
    L : matrix of the body (n, n), added to
    """
    if _exceeds(K, M, n, FAINT * s_squared):
        for a in range(3, n):
            for b in range(3, min(a, lead)):
                L[a, b] += stiffness * K[a, b]
            L[a, a] += stiffness * K[a, a]


@inlined
def _exceeds(K: Array, M: Array, n: int, s_squared: float) -> bool:
    """Return whether an entry of the diagonal of K exceeds s^2 M."""
    exceeds = False
    for a in range(3, n):
        exceeds = exceeds or abs(K[a, a]) > s_squared * M[a, a]
    return exceeds


@inlined
def update_tension(model: Model, workspace: Any, t: float, forces: Array, s_squared: float) -> None:
    """Bring tension (nb, n, n) up to date for a new matrix, 0 where it is not in use.

    `s_squared` is that of the step before if Newton's iteration has refused it, or 0: the refusal
    counts where tension exceeds a part of s^2 M (nb, n, n). Others: see `freeze_tension`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    workspace : memory of the run, whose matrices are frozen at its stage
    t : time [s]
    forces : multipliers of constraints and forces of elements (n_r,)
    s_squared : s^2 of the step before if Newton's iteration refused it, else 0 [1/s2]
    """
    clock, tension = workspace.clock, workspace.frozen.tension
    if clock[TENSE] > 0.0 or s_squared > 0.0:
        freeze_tension(model, workspace.work, t, workspace.stage, forces, tension)
    if s_squared > 0.0:
        count_refusal(model, clock, workspace.frozen.M, tension, s_squared)
    if not clock[TENSE] > 0.0:
        tension[:] = 0.0


@inlined
def count_refusal(model: Model, clock: Array, M: Array, tension: Array, s_squared: float) -> None:
    """Count a step that Newton's iteration has refused, if tension may be the reason.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    clock : times and factors of the step control (step_control.py)
    M : mass matrices by bodies (nb, n, n)
    tension : stiffness by tension by bodies (nb, n, n)
    s_squared : s^2 of the refused step [1/s2]
    """
    taut = False
    for i in range(model.n_body):
        taut = taut or _exceeds(tension[i], M[i], model.layout.size[i], TAUT * s_squared)
    if taut:
        clock[REFUSALS] += 1.0


@inlined
def judge(clock: Array) -> None:
    """Count an attempt; change the matrix where tension made Newton's iteration refuse many.

    The other one is taken if it has never been tried or has advanced faster. A run without
    refusals is one without tension.
    """
    clock[TRIED] += 1.0
    if clock[TRIED] < WINDOW:
        return
    pace, other, tense = (clock[TIME] - clock[SINCE]) / WINDOW, clock[OTHER], clock[TENSE] > 0.0
    slower = pace < FASTER * other if tense else FASTER * pace < other
    if clock[REFUSALS] > SHARE * WINDOW and slower:
        clock[TENSE], clock[OTHER] = 0.0 if tense else 1.0, pace
    clock[SINCE], clock[TRIED], clock[REFUSALS] = clock[TIME], 0.0, 0.0
