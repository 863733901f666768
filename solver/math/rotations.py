"""Vectors of three numbers as tuples, and rotations.

Each array of three numbers needs an allocation; compiled tuples stay in registers. Rotations: skew
matrices, Euler parameters, finite rotation vectors, shortest rotations.
"""

from typing import Any

import numpy as np

from .arrays import Array, Triple
from .compiled import inlined, lean


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
    """Return c0 x + c1 v x x + c2 v (v . x): rotations and tangent maps of a vector v.

    Parameters
    ----------
    v : rotation vector or axis
    c0 : coefficient of x
    c1 : coefficient of v x x
    c2 : coefficient of v (v . x)
    x : vector that is mapped
    """
    c, along = cross3(v, x), c2 * dot3(v, x)
    return (
        c0 * x[0] + c1 * c[0] + along * v[0],
        c0 * x[1] + c1 * c[1] + along * v[1],
        c0 * x[2] + c1 * c[2] + along * v[2],
    )


@inlined
def put_column(out: Array, i: int, j: int, a: Triple) -> None:
    """Write a into column j of an array, from row i on.

    Parameters
    ----------
    out : array to write to
    i : first row
    j : column
    a : the three numbers
    """
    out[i, j], out[i + 1, j], out[i + 2, j] = a[0], a[1], a[2]


@inlined
def tangent_rate(theta: Triple, theta_d: Triple, b: float, da: float, db: float) -> Triple:
    """Return (dT/dt) thetadot of the tangent map T of theta, at rates theta_d [rad/s].

    T = (1 - s b) 1 + a theta~ + b theta theta' with the coefficients of `tangent_coefficients`.

    Parameters
    ----------
    theta : rotation vector [rad]
    theta_d : its rate [rad/s]
    b : coefficient of `tangent_coefficients`
    da : da/ds of `tangent_coefficients`, s = theta . theta
    db : db/ds
    """
    s_d = 2.0 * dot3(theta, theta_d)
    c = cross3(theta, theta_d)
    c_2, c_3 = cross3(theta, c), cross3(theta_d, c)
    return (
        s_d * (da * c[0] + db * c_2[0]) + b * c_3[0],
        s_d * (da * c[1] + db * c_2[1]) + b * c_3[1],
        s_d * (da * c[2] + db * c_2[2]) + b * c_3[2],
    )


Quadruple = tuple[float, float, float, float]


def skew(a: Array) -> Array:
    """Return the matrix a~ with a~ b = a x b, (3, 3)."""
    return np.array(((0.0, -a[2], a[1]), (a[2], 0.0, -a[0]), (-a[1], a[0], 0.0)))


def rotation_matrix(p: Array) -> Array:
    """Return A_GB (3, 3) of Euler parameters p (4,), a rotation for any p != 0."""
    A_GB = np.empty((3, 3))
    rotation_into(p, A_GB)
    return A_GB


def rotation_matrices(p: Array) -> Array:
    """Return A_GB (k, 3, 3) of Euler parameters p (k, 4)."""
    A_GB = np.empty((len(p), 3, 3))
    _rotations_into(np.ascontiguousarray(p), A_GB)
    return A_GB


@lean
def _rotations_into(p: Array, A_GB: Array) -> None:
    for k in range(p.shape[0]):
        rotation_into(p[k], A_GB[k])


@lean
def rotation_into(p: Array, A_GB: Array) -> None:
    """Fill A_GB (3, 3) with the rotation of Euler parameters p (4,)."""
    e0, e1, e2, e3 = p[0], p[1], p[2], p[3]
    s = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    A_GB[0, 0] = 1.0 - s * (e2 * e2 + e3 * e3)
    A_GB[0, 1] = s * (e1 * e2 - e0 * e3)
    A_GB[0, 2] = s * (e1 * e3 + e0 * e2)
    A_GB[1, 0] = s * (e1 * e2 + e0 * e3)
    A_GB[1, 1] = 1.0 - s * (e1 * e1 + e3 * e3)
    A_GB[1, 2] = s * (e2 * e3 - e0 * e1)
    A_GB[2, 0] = s * (e1 * e3 - e0 * e2)
    A_GB[2, 1] = s * (e2 * e3 + e0 * e1)
    A_GB[2, 2] = 1.0 - s * (e1 * e1 + e2 * e2)


@inlined
def along_parameters(p: Array, a: int, w0: float, w1: float, w2: float) -> Quadruple:
    """Return E w for Euler parameters p[a:a+4]: 2 pdot at angular velocity w in body axes.

    Parameters
    ----------
    p : numbers with the four Euler parameters
    a : place of the first one
    w0 : angular velocity about x of the body [rad/s]
    w1 : about y [rad/s]
    w2 : about z [rad/s]
    """
    e0, e1, e2, e3 = p[a], p[a + 1], p[a + 2], p[a + 3]
    return (
        -e1 * w0 - e2 * w1 - e3 * w2,
        e0 * w0 - e3 * w1 + e2 * w2,
        e3 * w0 + e0 * w1 - e1 * w2,
        -e2 * w0 + e1 * w1 + e0 * w2,
    )


@lean
def tangent_coefficients(s: float) -> Quadruple:
    """Return a = (1 - cos x)/x2, b = (x - sin x)/x3 and da/ds, db/ds at s = x2.

    Both are entire functions of s: below 0.05 their series (error < 1e-17)
    avoids the cancellation of the closed forms.
    """
    if s < 0.05:
        a = 1 / 2 - s * (
            1 / 24 - s * (1 / 720 - s * (1 / 40320 - s * (1 / 3628800 - s / 479001600)))
        )
        b = 1 / 6 - s * (
            1 / 120 - s * (1 / 5040 - s * (1 / 362880 - s * (1 / 39916800 - s / 6227020800)))
        )
        da = -1 / 24 + s * (1 / 360 - s * (1 / 13440 - s * (1 / 907200 - s / 95800320)))
        db = -1 / 120 + s * (1 / 2520 - s * (1 / 120960 - s * (1 / 9979200 - s / 1245404160)))
        return a, b, da, db
    x = np.sqrt(s)
    a = (1.0 - np.cos(x)) / s
    b = (x - np.sin(x)) / (s * x)
    da = (0.5 * np.sin(x) / x - a) / s
    db = (0.5 * a - 1.5 * b) / s
    return a, b, da, db


def vector_to_matrix(theta: Array) -> Array:
    """Return exp(theta~) (3, 3), the rotation by |theta| about theta (3,) [rad]."""
    return np.asarray(vectors_to_matrices(theta[None])[0])


def vectors_to_matrices(theta: Array) -> Array:
    """Return exp(theta~) (k, 3, 3) of rotation vectors (k, 3) [rad]."""
    A = np.empty((len(theta), 3, 3))
    _exponentials_into(np.ascontiguousarray(theta), A)
    return A


@lean
def _exponentials_into(theta: Array, A: Array) -> None:
    for k in range(theta.shape[0]):
        v = (theta[k, 0], theta[k, 1], theta[k, 2])
        s = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
        a, b, _, _ = tangent_coefficients(s)  # cos = 1 - s a, sin(x)/x = 1 - s b
        for n in range(3):
            e = (1.0 if n == 0 else 0.0, 1.0 if n == 1 else 0.0, 1.0 if n == 2 else 0.0)
            A[k, 0, n], A[k, 1, n], A[k, 2, n] = about(v, 1.0 - s * a, 1.0 - s * b, a, e)


def matrix_to_parameters(A_GB: Array) -> Array:
    """Return Euler parameters (4,) of a rotation matrix (3, 3), e0 >= 0."""
    x, y, z = np.asarray(A_GB, dtype=float).T.tolist()
    return np.array(parameters_of(tuple(x), tuple(y), tuple(z)))


@lean
def parameters_of(x: Triple, y: Triple, z: Triple) -> Quadruple:
    """Return Euler parameters of the rotation with columns x, y, z, e0 >= 0.

    Parameters
    ----------
    x : first column of the rotation matrix
    y : second column
    z : third column
    """
    trace = x[0] + y[1] + z[2]
    o0, o1, o2 = y[2] - z[1], z[0] - x[2], x[1] - y[0]
    # The largest of the four squares is the safe one to divide by.
    largest = max(max(trace, x[0]), max(y[1], z[2]))
    if trace == largest:
        p0, p1, p2, p3 = 1.0 + trace, o0, o1, o2
    elif x[0] == largest:
        p0, p1, p2, p3 = o0, 1.0 + 2.0 * x[0] - trace, x[1] + y[0], x[2] + z[0]
    elif y[1] == largest:
        p0, p1, p2, p3 = o1, y[0] + x[1], 1.0 + 2.0 * y[1] - trace, y[2] + z[1]
    else:
        p0, p1, p2, p3 = o2, z[0] + x[2], z[1] + y[2], 1.0 + 2.0 * z[2] - trace
    scale = 1.0 / np.sqrt(p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    if p0 < 0.0:
        scale = -scale
    return scale * p0, scale * p1, scale * p2, scale * p3


def matrix_to_vector(A: Array) -> Array:
    """Return the rotation vector (3,) of a rotation matrix (3, 3), up to half a turn [rad]."""
    x, y, z = np.asarray(A, dtype=float).T.tolist()
    return np.array(vector_of(tuple(x), tuple(y), tuple(z)))


@lean
def vector_of(x: Triple, y: Triple, z: Triple) -> Triple:
    """Return the rotation vector of the rotation with columns x, y, z, up to half a turn [rad].

    Parameters
    ----------
    x : first column of the rotation matrix
    y : second column
    z : third column
    """
    p0, p1, p2, p3 = parameters_of(x, y, z)
    half_sine = np.sqrt(p1 * p1 + p2 * p2 + p3 * p3)
    # near no rotation: theta / sin(theta / 2) -> 2
    factor = 2.0 * np.arctan2(half_sine, p0) / half_sine if half_sine > 1e-12 else 2.0
    return factor * p1, factor * p2, factor * p3


@lean
def moment_of_gradient(theta: Triple, g: Triple) -> Triple:
    """Return T^-T g: the moment whose power is that of g on the rate of a rotation vector theta.

    T = c0 1 + c1 theta~ + c2 theta theta' is the tangent map of theta. Its inverse divides by one
    along theta and by c0^2 + c1^2 theta'theta = 2 c1 across.
    """
    s = theta[0] * theta[0] + theta[1] * theta[1] + theta[2] * theta[2]
    a, b, _, _ = tangent_coefficients(s)
    c0 = 1.0 - s * b
    c2 = (1.0 - 0.5 * c0 / a) / s if s > 1e-8 else 1.0 / 12.0
    return about(theta, 0.5 * c0 / a, 0.5, c2, g)


def frame_from_axis(axis: Array) -> Array:
    """Return a rotation matrix (3, 3) whose third column is the unit vector along `axis`.

    The first column is the coordinate axis that is farthest from `axis`, made
    orthogonal to it: deterministic, and the identity for axis = z.
    """
    z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    start = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = start - (start @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def shortest_rotations(one: Array, two: Array) -> Array:
    """Return matrices (k, 3, 3) that turn directions (k, 3) to others, of any length.

    Opposite directions have no such rotation: they are left as they are.
    """
    normal = np.cross(one, two)
    sine = np.linalg.norm(normal, axis=1)
    angle = np.arctan2(sine, np.einsum("ka,ka->k", one, two))
    factor = np.divide(angle, sine, out=np.zeros_like(sine), where=sine > 0.0)
    return vectors_to_matrices(factor[:, None] * normal)
