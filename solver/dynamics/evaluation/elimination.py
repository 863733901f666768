"""Solution of [K J'; J -e] [a; mu] = [f; gamma], body by body, e diagonal.

Rows J are constraints, with e = 0 or the reciprocal of a penalty, and other rows that stand for
a part of K: mu = (J a - gamma) / e adds J' (1 / e) J (`Layout`). Their e is called softness.

K has one symmetric block per body. Each is factorised alone from its last coordinate to its
first, K_i = L' D L, so that modes go before the frame: modes of diagonal matrices are coupled
with the frame only and cost little. What the bodies leave is S = J K^-1 J' + e of the rows, in a
profile below its diagonal (model/layout.py):

    W_i = L_i^-T J_i',   S = sum W_i' D_i^-1 W_i + e,   S mu = sum W_i' D_i^-1 z_i - gamma,
    z_i = L_i^-T f_i,    a_i = L_i^-1 D_i^-1 (z_i - W_i mu).

A frame that is driven, by six rows P without modes, is no unknown: P a_f = gamma_P. Its modes
answer what it does, f_q - K_qf a_f, and its own equation gives the six multipliers at the end,
P' lambda_P = f_f - K_ff a_f - K_fq a_q - J_f' mu. These rows are not in S.

There is no pivoting: the mass matrix of a body is positive definite, and so is S of independent
constraints. Rows with negative softness take added inertia away (added_inertia.py); they
come behind the constraints at their body. The same code serves real and complex blocks.

Whether constraint rows depend on each other, whatever the masses of the bodies: a small pivot of
J K^-1 J' has two causes: rows that depend on each other, and a heavy body behind a light one,
which two rows hold almost as one. Only the first leaves forces undetermined.
"""

from ...math.arrays import Array, IntArray
from ...math.compiled import inlined, lean
from ..elements.joints.table import DRIVES, KINDS
from ..model.layout import Layout, RowOrder
from ..model.model import Factors, Model
from ..tolerances import CLEARLY_REGULAR


@lean
def factorise(layout: Layout, order: RowOrder, factors: Factors, J: Array, softness: Array) -> None:
    """Factorise: L holds the lower triangles of K on entry; J (nb, n, r) is transposed.

    `softness` (n_r,), by row of `order`, is added to the diagonal of S.

    Parameters
    ----------
    layout : structure of the model (model/layout.py)
    order : order of the rows, and their profile
    factors : K on entry, the factors on return
    J : Jacobians by bodies (nb, n, r)
    softness : e of each row (n_r,)
    """
    S, profile, place = factors.S, order.profile_start, order.place
    for k in range(S.shape[0]):
        S[k] = 0.0
    for row in range(softness.shape[0]):
        if place[row] >= 0:
            S[profile[place[row] + 1] - 1] = softness[row]
    for i in range(layout.size.shape[0]):
        n, base, lead = layout.size[i], layout.base[i], layout.lead[i]
        _factorise_body(n, base, lead, factors.L[i], factors.pivot[i])
        _reduce_body(layout, order, factors, i, J[i])
        if base > 0:
            _factorise_frame(layout.driven_column[layout.driven_start[i] :], J[i], factors.P[i])
    factors.regular[0] = factorise_profile(order, S, factors.S_pivot)


@inlined
def _factorise_body(n: int, base: int, lead: int, L: Array, pivot: Array) -> None:
    """L' D L of the lower triangle of L (n, n) from `base` on; `pivot` gets 1 / D."""
    for k in range(n - 1, base - 1, -1):
        d = 1.0 / L[k, k]
        pivot[k] = d
        w = min(k, lead)
        for i in range(base, w):
            c = L[k, i] * d
            for j in range(base, i + 1):
                L[i, j] -= c * L[k, j]
        for i in range(base, w):
            L[k, i] *= d


@inlined
def _reduce_body(layout: Layout, order: RowOrder, factors: Factors, i: int, J: Array) -> None:
    """W = L^-T J of body i for its free columns of J (n, r), and its part of S."""
    n, base, lead = layout.size[i], layout.base[i], layout.lead[i]
    columns = order.free_column[order.free_start[i] : order.free_start[i + 1]]
    places = order.free_place[order.free_start[i] : order.free_start[i + 1]]
    L, pivot, W = factors.L[i], factors.pivot[i], factors.W[i]
    profile, S, r = order.profile_start, factors.S, columns.shape[0]
    for k in range(n):
        for p in range(r):
            W[k, p] = J[k, columns[p]]
    for k in range(n - 1, base, -1):
        for j in range(base, min(k, lead)):
            c = L[k, j]
            for p in range(r):
                W[j, p] -= c * W[k, p]
    for p in range(r):
        row = places[p]
        start = profile[row + 1] - 1 - row
        for k in range(base, n):
            w = W[k, p] * pivot[k]
            if w != 0.0:
                for q in range(p + 1):
                    S[start + places[q]] += w * W[k, q]


@inlined
def _factorise_frame(columns: IntArray, J: Array, P: Array) -> None:
    """L U of the six rows that drive a frame, in P (7, 6); the last row is their order."""
    for p in range(6):
        P[6, p] = columns[p]
        for k in range(6):
            P[p, k] = J[k, columns[p]]
    for k in range(6):
        best = k
        for p in range(k + 1, 6):
            if abs(P[p, k]) > abs(P[best, k]):
                best = p
        if best != k:
            for j in range(6):
                P[k, j], P[best, j] = P[best, j], P[k, j]
            P[6, k], P[6, best] = P[6, best], P[6, k]
        for p in range(k + 1, 6):
            P[p, k] /= P[k, k]
            for j in range(k + 1, 6):
                P[p, j] -= P[p, k] * P[k, j]


@inlined
def factorise_profile(order: RowOrder, S: Array, pivot: Array) -> float:
    """L D L' of a symmetric profile, in place.

    Returns the least pivot of a constraint over its diagonal entry before: small where
    constraints depend on each other.

    Parameters
    ----------
    order : order of the rows, and their profile
    S : profile of a symmetric matrix, then of L
    pivot : reciprocals of D (n_p,), to fill
    """
    first, profile, least = order.first, order.profile_start, 1.0
    for i in range(pivot.shape[0]):
        row = profile[i + 1] - 1 - i
        begin = first[i]
        # u_ij = S_ij - sum u_ik L_jk
        for j in range(begin, i):
            other = profile[j + 1] - 1 - j
            s = S[row + j]
            for k in range(max(begin, first[j]), j):
                s -= S[row + k] * S[other + k]
            S[row + j] = s
        whole = S[row + i]
        d = whole
        for j in range(begin, i):
            u = S[row + j]
            S[row + j] = u * pivot[j]
            d -= u * S[row + j]
        if order.constraint[i] > 0 and not abs(d) > least * abs(whole):
            least = abs(d) / abs(whole) if abs(whole) > 0.0 else 0.0
        S[row + i] = d
        pivot[i] = 1.0 / d if d != 0.0 else d
    return least


@inlined
def solve_profile(order: RowOrder, S: Array, pivot: Array, mu: Array) -> None:
    """Replace mu (n_p,), by place, by the solution of L D L' x = mu (`factorise_profile`).

    Parameters
    ----------
    order : order of the rows, and their profile
    S : profile of L
    pivot : reciprocals of D (n_p,)
    mu : right-hand side, then solution (n_p,), by place
    """
    first, profile = order.first, order.profile_start
    for i in range(pivot.shape[0]):
        row = profile[i + 1] - 1 - i
        s = mu[i]
        for j in range(first[i], i):
            s -= S[row + j] * mu[j]
        mu[i] = s
    for i in range(pivot.shape[0]):
        mu[i] *= pivot[i]
    for i in range(pivot.shape[0] - 1, -1, -1):
        row = profile[i + 1] - 1 - i
        s = mu[i]
        for j in range(first[i], i):
            mu[j] -= S[row + j] * s


@lean
def solve(
    layout: Layout,
    order: RowOrder,
    factors: Factors,
    f: Array,
    gamma: Array,
    a: Array,
    multipliers: Array,
) -> None:
    """Fill a (nb, n) and multipliers (k,) of right-hand sides f (nb, n), gamma (k,).

    k is the number of rows or less; gamma of the others is zero, their multipliers stay inside.

    Parameters
    ----------
    layout : structure of the model (model/layout.py)
    order : order of the rows, and their profile
    factors : factors of `factorise`
    f : right-hand sides by bodies (nb, n)
    gamma : right-hand sides of the rows (k,)
    a : solution by bodies (nb, n), to fill
    multipliers : multipliers of the rows (k,), to fill
    """
    mu, place = factors.mu, order.place
    mu[:] = 0.0
    for row in range(gamma.shape[0]):
        if place[row] >= 0:
            mu[place[row]] = -gamma[row]
    for i in range(layout.size.shape[0]):
        if layout.base[i] > 0:
            rows = layout.driven_row[layout.driven_start[i] :]
            columns = layout.driven_column[layout.driven_start[i] :]
            _drive(rows, columns, factors.P[i], gamma, a[i])
        _eliminate(layout, order, factors, i, f[i], a[i])
    solve_profile(order, factors.S, factors.S_pivot, mu)
    for row in range(gamma.shape[0]):
        if place[row] >= 0:
            multipliers[row] = mu[place[row]]
    for i in range(layout.size.shape[0]):
        _restore(layout, order, factors, i, a[i])
        if layout.base[i] > 0:
            _react(layout, order, factors, i, f[i], a[i], multipliers)


@inlined
def _eliminate(
    layout: Layout, order: RowOrder, factors: Factors, i: int, f: Array, a: Array
) -> None:
    """z = L^-T f of body i, and its part W' D^-1 z of the right-hand side of the multipliers.

    Below `base` the accelerations a are known.
    """
    n, base, lead, mu = layout.size[i], layout.base[i], layout.lead[i], factors.mu
    places = order.free_place[order.free_start[i] : order.free_start[i + 1]]
    L, pivot, W, z = factors.L[i], factors.pivot[i], factors.W[i], factors.z[i]
    for k in range(base, n):
        s = f[k]
        for j in range(base):
            s -= L[k, j] * a[j]
        z[k] = s
    for k in range(base):
        for p in range(places.shape[0]):
            mu[places[p]] += W[k, p] * a[k]
    for k in range(n - 1, base - 1, -1):
        s = z[k]
        for j in range(base, min(k, lead)):
            z[j] -= L[k, j] * s
        c = s * pivot[k]
        for p in range(places.shape[0]):
            mu[places[p]] += W[k, p] * c


@inlined
def _restore(layout: Layout, order: RowOrder, factors: Factors, i: int, a: Array) -> None:
    """a = L^-1 D^-1 (z - W mu) of body i, from `base` on."""
    n, base, lead, mu = layout.size[i], layout.base[i], layout.lead[i], factors.mu
    places = order.free_place[order.free_start[i] : order.free_start[i + 1]]
    L, pivot, W, z = factors.L[i], factors.pivot[i], factors.W[i], factors.z[i]
    for k in range(base, n):
        s = z[k]
        for p in range(places.shape[0]):
            s -= W[k, p] * mu[places[p]]
        s *= pivot[k]
        for j in range(base, min(k, lead)):
            s -= L[k, j] * a[j]
        a[k] = s


@inlined
def _drive(rows: IntArray, columns: IntArray, P: Array, gamma: Array, a: Array) -> None:
    """a[:6] of P a = gamma: the acceleration of a driven frame."""
    for p in range(6):
        for k in range(6):
            if P[6, p] == columns[k]:
                a[p] = gamma[rows[k]]
    for p in range(6):
        for j in range(p):
            a[p] -= P[p, j] * a[j]
    for p in range(5, -1, -1):
        for j in range(p + 1, 6):
            a[p] -= P[p, j] * a[j]
        a[p] /= P[p, p]


@inlined
def _react(
    layout: Layout,
    order: RowOrder,
    factors: Factors,
    i: int,
    f: Array,
    a: Array,
    multipliers: Array,
) -> None:
    """Multipliers of the rows that drive the frame of body i: P' lambda = what is left of f."""
    n, mu, P = layout.size[i], factors.mu, factors.P[i]
    rows = layout.driven_row[layout.driven_start[i] :]
    columns = layout.driven_column[layout.driven_start[i] :]
    places = order.free_place[order.free_start[i] : order.free_start[i + 1]]
    L, W, z = factors.L[i], factors.W[i], factors.z[i]
    for k in range(6):
        s = f[k]
        for j in range(k):
            s -= L[k, j] * a[j]
        for j in range(k, n):
            s -= L[j, k] * a[j]
        for p in range(places.shape[0]):
            s -= W[k, p] * mu[places[p]]
        z[k] = s
    for p in range(6):
        for j in range(p):
            z[p] -= P[j, p] * z[j]
        z[p] /= P[p, p]
    for p in range(5, -1, -1):
        for j in range(p + 1, 6):
            z[p] -= P[j, p] * z[j]
    for p in range(6):
        for k in range(6):
            if P[6, p] == columns[k]:
                multipliers[rows[k]] = z[p]


ABSENT = 1e100  # softness of a row that holds nothing
_DRIVES = frozenset(KINDS[name] for name in DRIVES)


def is_tree(model: Model) -> bool:
    """Return whether joints close no loop, so that no constraint row ever depends on others.

    Every joint leads to a body that no other one holds, and a drive takes a freedom that its joint
    leaves. Pivots are no measure then: that of the last joint of a chain falls with the third power
    of the number of links, whose inertia it moves.
    """
    if model.quantities.coupling_start.shape[0] > 1:
        return False
    root, pairs = list(range(model.n_body + 1)), set()
    driven: set[tuple[int, ...]] = set()

    def group(body: int) -> int:
        while root[body] != body:
            root[body] = root[root[body]]
            body = root[body]
        return body

    for kind, ends in zip(model.joint_kind, model.joint_marker.tolist(), strict=True):
        if kind in _DRIVES and tuple(ends) in pairs:
            if (int(kind), *ends) in driven:
                return False
            driven.add((int(kind), *ends))
            continue
        one, two = (group(int(model.marker_body[k]) % (model.n_body + 1)) for k in ends)
        if one == two:
            return False
        root[one] = two
        pairs.add(tuple(ends))
    return True


@lean
def rows_depend(model: Model, order: RowOrder, factors: Factors, J: Array, softness: Array) -> bool:
    """Return whether constraint rows depend on each other; overwrites `factors` and `softness`.

    Every body counts as one of unit mass with its own radius of gyration and its own modes, so
    that the pivots are those of the geometry.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    order : order of the rows, and their profile
    factors : memory, overwritten
    J : Jacobians by bodies (nb, n, r)
    softness : memory (n_r,), overwritten
    """
    for i in range(model.n_body):
        L, v = factors.L[i], model.vel_start[i]
        for a in range(model.layout.size[i]):
            for b in range(a):
                L[a, b] = 0.0
            L[a, a] = model.inertia_scale[v + a] / model.inertia_scale[v]
    for k in range(softness.shape[0]):
        softness[k] = 0.0 if k < model.n_constraint else ABSENT
    factorise(model.layout, order, factors, J, softness)
    return bool(factors.regular[0] < CLEARLY_REGULAR)
