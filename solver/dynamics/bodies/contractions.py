"""Second-order tables times modal coordinates and rates."""

from ...math.arrays import Array
from ...math.compiled import COMPILED, lean
from ...math.triple import Triple


@lean
def contract(T: Array, start: int, q: Array, q_d: Array, slope: Array) -> Triple:
    """Contract a table symmetric in two modes: return q T q, q T q_d, q_d T q_d.

    Parameters
    ----------
    T : flat, the table (m, m) from `start` on
    q, q_d : (m,)
    slope : (m,) gets T q added
    """
    by_q, mixed, by_q_d = 0.0, 0.0, 0.0
    row = start
    for i in range(q.shape[0]):
        one, two = 0.0, 0.0
        for j in range(q.shape[0]):
            one += T[row + j] * q[j]
            two += T[row + j] * q_d[j]
        row += q.shape[0]
        slope[i] += one
        by_q += one * q[i]
        mixed += one * q_d[i]
        by_q_d += two * q_d[i]
    return by_q, mixed, by_q_d


@lean
def _looped_add_elastic(
    M: Array, f: Array, q: Array, q_d: Array, G3: Array, three: int, G4: Array, four: int
) -> None:
    m = q.shape[0]
    for i in range(m):
        f_i = 0.0
        for j in range(m):
            # E_i,jl is symmetric in j and l: each pair once
            for k in range(j, m):
                row = four + ((i * m + j) * m + k) * m
                e = G3[three + (i * m + j) * m + k]
                for n in range(m):
                    e += G4[row + n] * q[n]
                if j <= i:
                    M[6 + i, 6 + j] += e * q[k]
                f_i += e * q_d[j] * q_d[k]
                if k != j:
                    if k <= i:
                        M[6 + i, 6 + k] += e * q[j]
                    f_i += e * q_d[j] * q_d[k]
            if j <= i:
                s = 0.0
                for k in range(m):
                    s += G3[three + (j * m + i) * m + k] * q[k]
                M[6 + i, 6 + j] += s
        f[6 + i] -= f_i


def _add_elastic(
    M: Array, f: Array, q: Array, q_d: Array, G3: Array, three: int, G4: Array, four: int
) -> None:
    """Add the modal mass of the deformed body to M's lower triangle, and its velocity terms to f.

    With E_i,jl = G3_i,jl + G4_ik,jl q_k = sum m (db/dq_i) . h_jl:
    M_ij += E_i,jl q_l + G3_j,ik q_k and f_i -= E_i,jl q_d_j q_d_l.

    Parameters
    ----------
    M : (6 + m, 6 + m); f : (6 + m,); q, q_d : (m,)
    G3, G4 : flat as in `Model`, from `three` and `four` on
    """
    m = q.shape[0]
    G = G3[three : three + m**3].reshape(m, m, m)
    E = G + (G4[four : four + m**4].reshape(m**3, m) @ q).reshape(m, m, m)
    M[6 : 6 + m, 6 : 6 + m] += E @ q + (G @ q).T
    f[6 : 6 + m] -= (E @ q_d) @ q_d


# Without Numba, four nested loops would take most of the time.
add_elastic = _looped_add_elastic if COMPILED else _add_elastic
