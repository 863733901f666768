"""Vectors of three numbers as tuples: arithmetic of the step loop without allocation.

Each array of three numbers needs an allocation; compiled tuples stay in registers.
"""

from typing import Any

from .arrays import Array
from .compiled import inlined

Triple = tuple[float, float, float]


@inlined
def triple(a: Any) -> Triple:
    """Return the three numbers of an array (3,)."""
    return a[0], a[1], a[2]


@inlined
def column(A: Array, j: int) -> Triple:
    """Return column j of A (3, n)."""
    return A[0, j], A[1, j], A[2, j]


@inlined
def cross3(a: Triple, b: Triple) -> Triple:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def dot3(a: Triple, b: Triple) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def sum3(a: Triple, b: Triple) -> Triple:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def minus3(a: Triple, b: Triple) -> Triple:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def times3(s: float, a: Triple) -> Triple:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def turned(A: Array, a: Triple) -> Triple:
    """Return A a of a matrix (3, 3)."""
    return (
        A[0, 0] * a[0] + A[0, 1] * a[1] + A[0, 2] * a[2],
        A[1, 0] * a[0] + A[1, 1] * a[1] + A[1, 2] * a[2],
        A[2, 0] * a[0] + A[2, 1] * a[1] + A[2, 2] * a[2],
    )


@inlined
def turned_back(A: Array, a: Triple) -> Triple:
    """Return A' a of a matrix (3, 3)."""
    return (
        A[0, 0] * a[0] + A[1, 0] * a[1] + A[2, 0] * a[2],
        A[0, 1] * a[0] + A[1, 1] * a[1] + A[2, 1] * a[2],
        A[0, 2] * a[0] + A[1, 2] * a[1] + A[2, 2] * a[2],
    )


@inlined
def about(v: Triple, c0: float, c1: float, c2: float, x: Triple) -> Triple:
    """Return c0 x + c1 v x x + c2 v (v . x): rotations and tangent maps of a vector v."""
    c, along = cross3(v, x), c2 * dot3(v, x)
    return (
        c0 * x[0] + c1 * c[0] + along * v[0],
        c0 * x[1] + c1 * c[1] + along * v[1],
        c0 * x[2] + c1 * c[2] + along * v[2],
    )


@inlined
def put_column(out: Array, i: int, j: int, a: Triple) -> None:
    """Write a into column j of an array, from row i on."""
    out[i, j], out[i + 1, j], out[i + 2, j] = a[0], a[1], a[2]


@inlined
def tangent_rate(theta: Triple, theta_d: Triple, b: float, da: float, db: float) -> Triple:
    """Return (dT/dt) thetadot of the tangent map T of theta, at rates theta_d [rad/s].

    T and the coefficients b, da, db: `tangent_map`, `tangent_coefficients` (rotations.py).
    """
    s_d = 2.0 * dot3(theta, theta_d)
    c = cross3(theta, theta_d)
    c_2, c_3 = cross3(theta, c), cross3(theta_d, c)
    return (
        s_d * (da * c[0] + db * c_2[0]) + b * c_3[0],
        s_d * (da * c[1] + db * c_2[1]) + b * c_3[1],
        s_d * (da * c[2] + db * c_2[2]) + b * c_3[2],
    )
