"""Rows of the constraint equations, and the building blocks of all joints.

A joint is written between the frames of two markers. Each row holds the
constraint Phi, its rate as coefficients C of (v_1, w_1, v_2, w_2), Phi_t, and
gamma* = everything of the acceleration equation that is free of coordinate
accelerations, moved to the right. Paper: Eq. (10), Eq. (11).
"""

from ....math.arrays import Array, Triple
from ....math.compiled import jit
from ....math.rotations import cross3, dot3, minus3, sum3
from ...model.model import GAMMA, PHI, PHI_T
from ...model.motion import acceleration, axis, place, spin_rate, velocity
from ...model.motion import spin as spin_of


@jit
def same_point(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k..k+2: the origins of both markers coincide [m].

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    d = minus3(place(two), place(one))
    d_dd = minus3(acceleration(two), acceleration(one))
    for i in range(3):
        for j in range(12):
            rows[k + i, j] = 0.0
        rows[k + i, i] = -1.0
        rows[k + i, 6 + i] = 1.0
        rows[k + i, PHI] = d[i]
        rows[k + i, PHI_T] = 0.0
        rows[k + i, GAMMA] = -d_dd[i]


@jit
def along_axis(
    rows: Array, k: int, one: Array, two: Array, i: int, f: float, f_d: float, f_dd: float
) -> None:
    """Row k: origin of marker two stands at f along axis i of marker one [m].

    `f_d` and `f_dd` are the rates of f by time [m/s, m/s2].

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    i : axis of marker one, 0 to 2
    f : position along it [m]
    f_d : its rate [m/s]
    f_dd : its second rate [m/s2]
    """
    a, w = axis(one, i), spin_of(one)
    d = minus3(place(two), place(one))
    d_d = minus3(velocity(two), velocity(one))
    d_dd = minus3(acceleration(two), acceleration(one))
    a_d = cross3(w, a)
    n = cross3(a, d)
    rows[k, PHI] = dot3(a, d) - f
    rows[k, PHI_T] = -f_d
    a_dd = sum3(cross3(spin_rate(one), a), cross3(w, a_d))
    gamma = f_dd - 2.0 * dot3(a_d, d_d) - dot3(a_dd, d)
    for j in range(3):
        rows[k, j] = -a[j]
        rows[k, 3 + j] = n[j]
        rows[k, 6 + j] = a[j]
        rows[k, 9 + j] = 0.0
        gamma -= a[j] * d_dd[j]
    rows[k, GAMMA] = gamma


@jit
def orthogonal_axes(
    rows: Array,
    k: int,
    one: Array,
    two: Array,
    a: Triple,
    b: Triple,
    spin: Triple,
    turning_rate: Triple,
) -> None:
    """Row k: a . b = 0 with b fixed in marker two and a turning relative to marker one.

    `spin` is the angular velocity of a relative to marker one and `turning_rate`
    its global rate less alpha-terms of the coordinates [rad/s, rad/s2];
    both are zero for an axis fixed in marker one.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    a : first axis, global
    b : second axis, global; fixed in marker two
    spin : angular velocity of a relative to marker one, global [rad/s]
    turning_rate : its rate without the coordinate accelerations [rad/s2]
    """
    w, w_two = sum3(spin_of(one), spin), spin_of(two)
    rates = sum3(minus3(spin_rate(one), spin_rate(two)), turning_rate)
    n = cross3(a, b)
    n_d = sum3(cross3(cross3(w, a), b), cross3(a, cross3(w_two, b)))
    rows[k, PHI] = dot3(a, b)
    rows[k, PHI_T] = dot3(spin, n)
    gamma = 0.0
    for i in range(3):
        rows[k, i] = 0.0
        rows[k, 3 + i] = n[i]
        rows[k, 6 + i] = 0.0
        rows[k, 9 + i] = -n[i]
        gamma -= rates[i] * n[i] + (w[i] - w_two[i]) * n_d[i]
    rows[k, GAMMA] = gamma


@jit
def fixed_axes(rows: Array, k: int, one: Array, two: Array, i: int, j: int) -> None:
    """Row k: axis i of marker one is orthogonal to axis j of marker two.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    i : axis of marker one, 0 to 2
    j : axis of marker two, 0 to 2
    """
    zero = (0.0, 0.0, 0.0)
    orthogonal_axes(rows, k, one, two, axis(one, i), axis(two, j), zero, zero)


@jit
def parallel_z(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k, k+1: the z axes of both markers stay parallel.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    fixed_axes(rows, k, one, two, 0, 2)
    fixed_axes(rows, k + 1, one, two, 1, 2)


@jit
def on_z_axis(rows: Array, k: int, one: Array, two: Array) -> None:
    """Rows k, k+1: the origin of marker two stays on the z axis of marker one [m].

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    """
    along_axis(rows, k, one, two, 0, 0.0, 0.0, 0.0)
    along_axis(rows, k + 1, one, two, 1, 0.0, 0.0, 0.0)
