"""Tables of second order times modal coordinates: loops where compiled, NumPy's product where not.

The compiled forms allocate nothing, the others call no loop: see small.py.
"""

import numpy as np

from ..compiled import COMPILED, jit
from ..package.schema import Array


@jit
def _looped_contract(T: Array, q: Array, q_d: Array, slope: Array, parts: Array) -> None:
    r, m = slope.shape
    for a in range(r):
        by_q, mixed, by_q_d = 0.0, 0.0, 0.0
        for i in range(m):
            one, two = 0.0, 0.0
            for j in range(m):
                h = T[a * m + i, j]
                one += h * q[j]
                two += h * q_d[j]
            slope[a, i] = one
            by_q += one * q[i]
            mixed += one * q_d[i]
            by_q_d += two * q_d[i]
        parts[0, a], parts[1, a], parts[2, a] = by_q, mixed, by_q_d


def _contract(T: Array, q: Array, q_d: Array, slope: Array, parts: Array) -> None:
    """Contract a table symmetric in two modes with coordinates and rates, in place.

    Parameters
    ----------
    T : (r m, m)
    q, q_d : (m,)
    slope : (r, m) becomes T q
    parts : (3, r) becomes q T q, q T q_d, q_d T q_d
    """
    np.dot(T, q, out=slope.reshape(-1))
    np.dot(slope, q, out=parts[0])
    np.dot(slope, q_d, out=parts[1])
    np.dot((T @ q_d).reshape(slope.shape), q_d, out=parts[2])


@jit
def _looped_add_elastic(M: Array, f: Array, q: Array, q_d: Array, G3: Array, G4: Array) -> None:
    m = q.shape[0]
    for i in range(m):
        f_i = 0.0
        for j in range(m):
            # E_i,jl is symmetric in j and l: each pair once
            for k in range(j, m):
                row = (i * m + j) * m + k
                e = G3[i, j * m + k]
                for n in range(m):
                    e += G4[row, n] * q[n]
                M[6 + i, 6 + j] += e * q[k]
                f_i += e * q_d[j] * q_d[k]
                if k != j:
                    M[6 + i, 6 + k] += e * q[j]
                    f_i += e * q_d[j] * q_d[k]
            s = 0.0
            for k in range(m):
                s += G3[j, i * m + k] * q[k]
            M[6 + i, 6 + j] += s
        f[6 + i] -= f_i


def _add_elastic(M: Array, f: Array, q: Array, q_d: Array, G3: Array, G4: Array) -> None:
    """Add the modal mass of the bent body to M and its velocity terms to f, in place.

    With E_i,jl = G3_i,jl + G4_ik,jl q_k = sum m (db/dq_i) . h_jl:
    M_ij += E_i,jl q_l + G3_j,ik q_k and f_i -= E_i,jl q_d_j q_d_l.

    Parameters
    ----------
    M : (6 + m, 6 + m); f : (6 + m,); q, q_d : (m,)
    G3 : (m, m m); G4 : (m m m, m), rows i, j, l and columns k of G4_ik,jl
    """
    m = q.shape[0]
    E = (G3 + (G4 @ q).reshape(m, m * m)).reshape(m, m, m)
    M[6:, 6:] += E @ q + (G3.reshape(m, m, m) @ q).T
    f[6:] -= (E @ q_d) @ q_d


contract = _looped_contract if COMPILED else _contract
add_elastic = _looped_add_elastic if COMPILED else _add_elastic
