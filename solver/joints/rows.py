"""Rows of the constraint equations, and the building blocks of all joints.

A joint is written between the frames of two markers. Each row holds the
constraint Phi, its rate as coefficients C of (v_1, w_1, v_2, w_2), Phi_t, and
gamma* = everything of the acceleration equation that is free of coordinate
accelerations, moved to the right. Paper: Eq. (10), Eq. (11).
"""

from typing import NamedTuple

import numpy as np

from ..bodies.marker import Marker
from ..compiled import jit
from ..package.schema import Array
from ..rotations import cross, dot


class Rows(NamedTuple):
    """All constraint rows of a system, filled joint by joint."""

    Phi: Array  # (n,)
    C: Array  # (n, 12): coefficients of v_1, w_1, v_2, w_2, global components
    Phi_t: Array  # (n,)
    gamma: Array  # (n,): gamma*


@jit
def same_point(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k..k+2: the origins of both markers coincide [m]."""
    for i in range(3):
        rows.Phi[k + i] = two.x[i] - one.x[i]
        rows.C[k + i] = 0.0
        rows.C[k + i, i] = -1.0
        rows.C[k + i, 6 + i] = 1.0
        rows.Phi_t[k + i] = 0.0
        rows.gamma[k + i] = one.a[i] - two.a[i]


@jit
def along_axis(
    rows: Rows, k: int, one: Marker, two: Marker, i: int, f: float, f_d: float, f_dd: float
) -> None:
    """Row k: origin of marker two stands at f along axis i of marker one [m].

    `f_d` and `f_dd` are the rates of f by time [m/s, m/s2].
    """
    a = one.A[:, i].copy()
    d = two.x - one.x
    d_d = two.v - one.v
    a_d = cross(one.w, a)
    n = cross(a, d)
    rows.Phi[k] = dot(a, d) - f
    rows.Phi_t[k] = -f_d
    gamma = f_dd - 2.0 * dot(a_d, d_d) - dot(cross(one.alpha, a) + cross(one.w, a_d), d)
    for j in range(3):
        rows.C[k, j] = -a[j]
        rows.C[k, 3 + j] = n[j]
        rows.C[k, 6 + j] = a[j]
        rows.C[k, 9 + j] = 0.0
        gamma -= a[j] * (two.a[j] - one.a[j])
    rows.gamma[k] = gamma


@jit
def orthogonal_axes(
    rows: Rows,
    k: int,
    one: Marker,
    two: Marker,
    a: Array,
    b: Array,
    spin: Array,
    spin_rate: Array,
) -> None:
    """Row k: a . b = 0 with b fixed in marker two and a turning relative to marker one.

    `spin` is the angular velocity of a relative to marker one and `spin_rate`
    its global rate less alpha-terms of the coordinates, (3,) [rad/s, rad/s2];
    both are zero for an axis fixed in marker one.
    """
    w = one.w + spin
    n = cross(a, b)
    n_d = cross(cross(w, a), b) + cross(a, cross(two.w, b))
    rows.Phi[k] = dot(a, b)
    rows.Phi_t[k] = dot(spin, n)
    gamma = 0.0
    for i in range(3):
        rows.C[k, i] = 0.0
        rows.C[k, 3 + i] = n[i]
        rows.C[k, 6 + i] = 0.0
        rows.C[k, 9 + i] = -n[i]
        gamma -= (one.alpha[i] - two.alpha[i] + spin_rate[i]) * n[i]
        gamma -= (w[i] - two.w[i]) * n_d[i]
    rows.gamma[k] = gamma


@jit
def fixed_axes(rows: Rows, k: int, one: Marker, two: Marker, i: int, j: int) -> None:
    """Row k: axis i of marker one is orthogonal to axis j of marker two."""
    zero = np.zeros(3)
    orthogonal_axes(rows, k, one, two, one.A[:, i].copy(), two.A[:, j].copy(), zero, zero)


@jit
def parallel_z(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k, k+1: the z axes of both markers stay parallel."""
    fixed_axes(rows, k, one, two, 0, 2)
    fixed_axes(rows, k + 1, one, two, 1, 2)


@jit
def on_z_axis(rows: Rows, k: int, one: Marker, two: Marker) -> None:
    """Rows k, k+1: the origin of marker two stays on the z axis of marker one [m]."""
    along_axis(rows, k, one, two, 0, 0.0, 0.0, 0.0)
    along_axis(rows, k + 1, one, two, 1, 0.0, 0.0, 0.0)
