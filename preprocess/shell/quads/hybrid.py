"""Membrane of a quadrilateral: assumed resultants in equilibrium, sides that bow.

With x, y from the centroid of the area, the resultants N = P beta are the complete linear field in
equilibrium, which has no preferred axes,

    Nx = b1 + b4 y + b6 x,   Ny = b2 + b5 x + b7 y,   Nxy = b3 - b6 y - b7 x.

Displacements are needed on the sides only: linear between the corners, and bowed by
a (L_k/8) (tz_j - tz_i) P_k along n_k = (t_y, -t_x), as in Allman's triangle. With the strain
e + A^-1 B k of the displacements and the curvature k, the Hellinger-Reissner functional

    int N'(e + A^-1 B k) - N' A^-1 N/2 + k'(D - B A^-1 B) k/2

gives beta = H^-1 G u, H = int P' A^-1 P, G u = int P'(e + A^-1 B k). The stiffness G' H^-1 G is the
square of y = L^-1 G u with H = L L'. In a constant state neighbours fit together if their common
side bows alike. Thus a is that of the triangles (`bow` of the membrane) in rows b1 to b3, which
alone do work in a constant state, and 1 in the others.

Two motions of the rotations have no energy in this field, equal ones and alternating ones; they
get a small stiffness, which is zero in every constant state.
"""

from typing import Any, NamedTuple

from ufl import as_vector, dot, inv, sqrt

from ..cell import Cell, Point
from ..membranes.strains import bow_strain, linear_strain
from ..quadrilaterals import CORNERS

SPURIOUS = 0.1  # of equal rotations relative to that of the cell, to A66 (as in allman.py)
HOURGLASS = 1e-3  # of alternating rotations, to A66
ALTERNATING = [float(xi * eta) for xi, eta in CORNERS.tolist()]  # 1, -1, 1, -1


class Hybrid(NamedTuple):
    """The membrane with its coupling to the plate.

    `pairs` of stress and strain of the whole cell, and the mean `strain` (exx, eyy, gxy).
    """

    pairs: list[tuple[Any, Any]]
    strain: Any


def hybrid(q: Cell, curvature: list[Any]) -> Hybrid:
    """Stiffness of the membrane, for the curvature at the points of the cell."""
    flexible = inv(q.A)
    P = [_field(q, point) for point in q.points]
    H = [
        [
            sum(p.weight * dot(Pm[m], flexible * Pm[n]) for p, Pm in zip(q.points, P, strict=True))
            for n in range(m + 1)
        ]
        for m in range(7)
    ]
    work: list[Any] = [0.0] * 7
    for point, Pm, k in zip(q.points, P, curvature, strict=True):
        straight, bowed = linear_strain(point, q.feet), bow_strain(q, point)
        bent = flexible * q.B * k
        for m in range(7):
            a = q.bow if m < 3 else 1.0
            work[m] += point.weight * dot(Pm[m], straight + a * bowed + bent)
    L = _cholesky(H)
    y = _forward(L, work)
    beta = _backward(L, y)
    k = sum(
        (p.weight * k for p, k in zip(q.points, curvature, strict=True)),
        as_vector((0.0, 0.0, 0.0)),
    )
    # the mean of x and of y is zero
    strain = flexible * (as_vector(beta[:3]) - q.B * (k / q.area))
    whole = as_vector(y)
    return Hybrid([(whole, whole), *_steadying(q)], strain)


def _field(q: Cell, point: Point) -> list[Any]:
    """Columns of P at a point, with x and y in units of the cell's size, so that all are alike."""
    x, y = (point.xy[i] / sqrt(q.area) for i in range(2))
    columns = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (y, 0.0, 0.0), (0.0, x, 0.0),
               (x, 0.0, -y), (0.0, y, -x)]  # fmt: skip
    return [as_vector(column) for column in columns]


def _steadying(q: Cell) -> list[tuple[Any, Any]]:
    """Stiffness of the two motions of the rotations without energy."""
    mean = as_vector([sum(q.excess(q.feet)) / 4.0])
    h = []
    for j, g in enumerate(q.centre):
        h.append(ALTERNATING[j] - sum(ALTERNATING[i] * dot(q.xy[i], g) for i in range(4)))
    other = as_vector([0.25 * sum(h[j] * q.corners[j].tz for j in range(4))])
    size = q.A[2, 2] * q.area
    return [(SPURIOUS * size * mean, mean), (HOURGLASS * size * other, other)]


def _cholesky(H: list[list[Any]]) -> list[list[Any]]:
    """Lower triangle L of H = L L', from that of H."""
    L: list[list[Any]] = []
    for i, row in enumerate(H):
        L.append([])
        for j in range(i):
            known = sum(L[i][k] * L[j][k] for k in range(j))
            L[i].append((row[j] - known) / L[j][j])
        L[i].append(sqrt(row[i] - sum(L[i][k] ** 2 for k in range(i))))
    return L


def _forward(L: list[list[Any]], b: list[Any]) -> list[Any]:
    """L^-1 b."""
    y: list[Any] = []
    for i, value in enumerate(b):
        y.append((value - sum(L[i][k] * y[k] for k in range(i))) / L[i][i])
    return y


def _backward(L: list[list[Any]], y: list[Any]) -> list[Any]:
    """L'^-1 y."""
    n = len(y)
    x: list[Any] = [None] * n
    for i in reversed(range(n)):
        x[i] = (y[i] - sum(L[k][i] * x[k] for k in range(i + 1, n))) / L[i][i]
    return x
