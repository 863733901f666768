"""Stiffness that forces of joints give to rotations of bodies: that of a taut cable, for example.

A joint that acts on a body with a force f at x, both in body axes, turns with the body at x only:
a small rotation phi changes its moment by -(x . f - f x') phi. Summed over the joints of a body,
K = sum (x . f) I - sym(f x'). Light links that carry a heavy load vibrate across it at high
frequencies by this stiffness; without it in the matrix, Newton's iteration would converge only
where steps resolve these vibrations. Its negative part, of links that are compressed, is left
out: the matrix stays positive, and Newton's iteration has to converge without it.
"""

from ...dynamics.bodies.motion import place
from ...dynamics.constraint_rows import n_coupling
from ...dynamics.model import Model
from ...dynamics.workspace import Work
from ...math.arrays import Array
from ...math.compiled import inlined, lean

FAINT = 1e-2  # of the inertia times s^2: less stiffness does not delay Newton's iteration
SWEEPS = 4  # of Jacobi's rotations of a matrix (3, 3)


@lean
def freeze_tension(model: Model, work: Work, y: Array, tension: Array) -> None:
    """Fill tension[i, :3] with K [N m/rad] of body i, of the multipliers of the last evaluation."""
    tension[:] = 0.0
    for k in range(model.joint_kind.shape[0] - n_coupling(model)):
        begin, end = model.joint_row[k], model.joint_row[k + 1]
        for side in range(2):
            marker = model.joint_marker[k, side]
            i = model.marker_body[marker]
            if i >= 0:
                f0, f1, f2 = 0.0, 0.0, 0.0
                for p in range(begin, end):
                    f0 -= work.rows[p, 6 * side] * work.multipliers[p]
                    f1 -= work.rows[p, 6 * side + 1] * work.multipliers[p]
                    f2 -= work.rows[p, 6 * side + 2] * work.multipliers[p]
                x, a, A, K = place(work.motion[marker]), model.pos_start[i], work.A[i], tension[i]
                x0, x1, x2 = x[0] - y[a], x[1] - y[a + 1], x[2] - y[a + 2]
                along = x0 * f0 + x1 * f1 + x2 * f2
                for b in range(3):
                    x_b = A[0, b] * x0 + A[1, b] * x1 + A[2, b] * x2
                    f_b = A[0, b] * f0 + A[1, b] * f1 + A[2, b] * f2
                    K[b, b] += along
                    for c in range(3):
                        x_c = A[0, c] * x0 + A[1, c] * x1 + A[2, c] * x2
                        f_c = A[0, c] * f0 + A[1, c] * f1 + A[2, c] * f2
                        K[b, c] -= 0.5 * (f_b * x_c + x_b * f_c)


@inlined
def add_tension(K: Array, M: Array, s_squared: float, stiffness: float, L: Array) -> None:
    """Add the positive part of K (6, 3) of one body, times stiffness, to L (n, n) of the body.

    Without effect where K is faint against s^2 M (n, n). K has 3 more rows, as working memory;
    its first three are replaced by their positive part.
    """
    counts = False
    for a in range(3):
        counts = counts or abs(K[a, a]) > FAINT * s_squared * M[3 + a, 3 + a]
    if counts:
        keep_positive(K)
        for a in range(3):
            for b in range(a + 1):
                L[3 + a, 3 + b] += stiffness * K[a, b]


@lean
def keep_positive(K: Array) -> None:
    """Replace the symmetric K[:3] by the part of its positive eigenvalues; K[3:] is memory.

    Eigenvectors V by Jacobi's rotations (Golub and Van Loan, Matrix Computations, section 8.5).
    """
    V = K[3:]
    for a in range(3):
        for b in range(3):
            V[a, b] = 1.0 if a == b else 0.0
    for _ in range(SWEEPS):
        for p in range(2):
            for q in range(p + 1, 3):
                if K[q, p] != 0.0:
                    tau = (K[q, q] - K[p, p]) / (2.0 * K[q, p])
                    t = 1.0 / (abs(tau) + (1.0 + tau * tau) ** 0.5)
                    t = t if tau >= 0.0 else -t
                    c = 1.0 / (1.0 + t * t) ** 0.5
                    s = t * c
                    for k in range(3):
                        a, b = K[k, p], K[k, q]
                        K[k, p], K[k, q] = c * a - s * b, s * a + c * b
                        a, b = V[k, p], V[k, q]
                        V[k, p], V[k, q] = c * a - s * b, s * a + c * b
                    for k in range(3):
                        a, b = K[p, k], K[q, k]
                        K[p, k], K[q, k] = c * a - s * b, s * a + c * b
    l0, l1, l2 = max(K[0, 0], 0.0), max(K[1, 1], 0.0), max(K[2, 2], 0.0)
    for a in range(3):
        for b in range(3):
            K[a, b] = l0 * V[a, 0] * V[b, 0] + l1 * V[a, 1] * V[b, 1] + l2 * V[a, 2] * V[b, 2]
