"""Solution of [K Phi_q'; Phi_q 0] [a; lambda] = [f; gamma], body by body.

K has one symmetric block per body. Each is factorised alone, K_i = L D L'; what the bodies leave
is S = Phi_q K^-1 Phi_q' of the constraint rows, in a profile below its diagonal (plan.py):

    W_i = L_i^-1 Phi_q,i',   S = sum W_i' D_i^-1 W_i,   S lambda = sum W_i' D_i^-1 z_i - gamma,
    z_i = L_i^-1 f_i,        a_i = L_i^-T D_i^-1 (z_i - W_i lambda).

There is no pivoting: the mass matrix of a body is positive definite, and so is S while the
constraints are independent. The same code serves real and complex symmetric blocks.
"""

from .compiled import inlined, jit
from .package.schema import Array, IntArray
from .plan import Plan
from .workspace import Factors


@jit
def factorise(plan: Plan, factors: Factors, J: Array, softness: Array) -> None:
    """Factorise: L holds the lower triangles of K on entry; J (nb, n, r) is Phi_q'.

    `softness` (n_c,), by constraint row, is added to the diagonal of S: reciprocal penalties.
    """
    S, profile, place = factors.S, plan.profile_start, plan.place
    for k in range(S.shape[0]):
        S[k] = 0.0
    for row in range(softness.shape[0]):
        S[profile[place[row] + 1] - 1] = softness[row]
    for i in range(plan.size.shape[0]):
        n, rows = plan.size[i], plan.body_place[plan.row_start[i] : plan.row_start[i + 1]]
        _factorise_body(n, factors.L[i], factors.pivot[i])
        _reduce_body(n, rows, profile, factors.L[i], factors.pivot[i], J[i], factors.W[i], S)
    factors.regular[0] = _factorise_profile(plan.first, profile, S, factors.S_pivot)


@inlined
def _factorise_body(n: int, L: Array, pivot: Array) -> None:
    """L D L' of the lower triangle of L (n, n), in place; `pivot` gets the reciprocals of D."""
    for k in range(n):
        d = 1.0 / L[k, k]
        pivot[k] = d
        for i in range(k + 1, n):
            c = L[i, k] * d
            for j in range(k + 1, i + 1):
                L[i, j] -= c * L[j, k]
        for i in range(k + 1, n):
            L[i, k] *= d


@inlined
def _reduce_body(
    n: int,
    rows: IntArray,
    profile: IntArray,
    L: Array,
    pivot: Array,
    J: Array,
    W: Array,
    S: Array,
) -> None:
    """W = L^-1 J of a body with constraints at the places `rows` (r,), and its part of S."""
    r = rows.shape[0]
    for k in range(n):
        for p in range(r):
            W[k, p] = J[k, p]
        for j in range(k):
            c = L[k, j]
            for p in range(r):
                W[k, p] -= c * W[j, p]
    for p in range(r):
        row = rows[p]
        start = profile[row + 1] - 1 - row
        for q in range(r):
            other = rows[q]
            if other <= row:
                s = W[0, p] * pivot[0] * W[0, q]
                for k in range(1, n):
                    s += W[k, p] * pivot[k] * W[k, q]
                S[start + other] += s


@inlined
def _factorise_profile(first: IntArray, profile: IntArray, S: Array, pivot: Array) -> float:
    """L D L' of a symmetric profile, in place.

    Returns the least pivot over its diagonal entry before: small where rows depend on others.
    """
    least = 1.0
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
        if not abs(d) > least * abs(whole):
            least = abs(d) / abs(whole) if abs(whole) > 0.0 else 0.0
        S[row + i] = d
        pivot[i] = 1.0 / d if d != 0.0 else d
    return least


@jit
def solve(
    plan: Plan, factors: Factors, f: Array, gamma: Array, a: Array, multipliers: Array
) -> None:
    """Fill a (nb, n) and multipliers (n_c,) of right-hand sides f (nb, n), gamma (n_c,)."""
    mu, S, pivot = factors.mu, factors.S, factors.S_pivot
    first, profile, place = plan.first, plan.profile_start, plan.place
    n_c = gamma.shape[0]
    for row in range(n_c):
        mu[place[row]] = -gamma[row]
    for i in range(plan.size.shape[0]):
        n, rows = plan.size[i], plan.body_place[plan.row_start[i] : plan.row_start[i + 1]]
        _eliminate(n, rows, factors.L[i], factors.pivot[i], factors.W[i], f[i], factors.z[i], mu)
    for i in range(n_c):
        row = profile[i + 1] - 1 - i
        s = mu[i]
        for j in range(first[i], i):
            s -= S[row + j] * mu[j]
        mu[i] = s
    for i in range(n_c):
        mu[i] *= pivot[i]
    for i in range(n_c - 1, -1, -1):
        row = profile[i + 1] - 1 - i
        s = mu[i]
        for j in range(first[i], i):
            mu[j] -= S[row + j] * s
    for row in range(n_c):
        multipliers[row] = mu[place[row]]
    for i in range(plan.size.shape[0]):
        n, rows = plan.size[i], plan.body_place[plan.row_start[i] : plan.row_start[i + 1]]
        _restore(n, rows, factors.L[i], factors.pivot[i], factors.W[i], factors.z[i], mu, a[i])


@inlined
def _eliminate(
    n: int, rows: IntArray, L: Array, pivot: Array, W: Array, f: Array, z: Array, mu: Array
) -> None:
    """z = L^-1 f of a body, and its part W' D^-1 z of the right-hand side of the multipliers."""
    for k in range(n):
        s = f[k]
        for j in range(k):
            s -= L[k, j] * z[j]
        z[k] = s
    for k in range(n):
        c = z[k] * pivot[k]
        for p in range(rows.shape[0]):
            mu[rows[p]] += W[k, p] * c


@inlined
def _restore(
    n: int, rows: IntArray, L: Array, pivot: Array, W: Array, z: Array, mu: Array, a: Array
) -> None:
    """a = L^-T D^-1 (z - W mu) of a body."""
    for k in range(n):
        s = z[k]
        for p in range(rows.shape[0]):
            s -= W[k, p] * mu[rows[p]]
        a[k] = s * pivot[k]
    for k in range(n - 1, -1, -1):
        s = a[k]
        for j in range(k):
            a[j] -= L[k, j] * s
