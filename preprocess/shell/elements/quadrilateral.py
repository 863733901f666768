"""Quadrilaterals: their membrane, and rotations inside of their cells.

The membrane has assumed resultants in equilibrium and sides that bow.

With x, y from the centroid of the area, the resultants N = P beta are the complete linear field in
equilibrium, which has no preferred axes,

    Nx = b5 + b1 y + b3 x,   Ny = b6 + b2 x + b4 y,   Nxy = b7 - b3 y - b4 x.

Displacements are needed on the sides only: linear between the corners, and bowed by
a (L_k/8) (tz_j - tz_i) P_k along n_k = (t_y, -t_x), as in Allman's triangle. With the strain
e + A^-1 B k of the displacements and the curvature k, the Hellinger-Reissner functional

    int N'(e + A^-1 B k) - N' A^-1 N/2 + k'(D - B A^-1 B) k/2

gives beta = H^-1 G u, H = int P' A^-1 P, G u = int P'(e + A^-1 B k). The stiffness G' H^-1 G is the
square of y = L^-1 G u with H = L L'. In a constant state neighbours fit together if their common
side bows alike. Thus a is that of the triangles (`bow` of the membrane) in rows b5 to b7, which
alone do work in a constant state, and 1 in the others.

Two motions of the rotations have no energy in this field, equal ones and alternating ones; they
get a small stiffness, which is zero in every constant state.

Internal rotations are for a quadrilateral that is narrow compared with its thickness.
In torsion of a narrow strip the rotation along the strip is a hyperbolic sine across its width, and
bilinear rotations of one cell are too stiff by up to 13 %. Each cell therefore has two rotations of
its own, of cubic shape f(s) = s^3 - s, zero on the sides that they run along:

    b = c_1 t_1 f(eta) + c_2 t_2 f(xi),

with unit vectors t_1, t_2 along xi and eta at the centre. The mean of their curvature and of their
shear strain is zero (both are taken with the derivatives of the centre), so every constant state
is kept; they only answer to a shear strain along one direction that varies across it. Integrals
over a square of side 2: int f'^2 = 16/5, int f^2 = 32/105, and int f g = -(2/5) int s g for g
linear in s. The curvature of the corners' motion does no work on f'. All other products of the two
vanish, so each is eliminated alone.
"""

from typing import Any, NamedTuple

from ufl import as_vector, dot, inv, sqrt

from ..shell_cells import CORNERS, GAUSS
from .cell import Cell, Point
from .membranes.contract import bow_strain, linear_strain

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
    size = sqrt(q.area)
    by_x = _moment(q, curvature, [point.xy[0] / size for point in q.points], 1.0)
    by_y = _moment(q, curvature, [point.xy[1] / size for point in q.points], 1.0)
    by_1 = _moment(q, curvature, [1.0] * 4, q.bow)
    work = [by_y[0], by_x[1], by_x[0] - by_y[2], by_y[1] - by_x[2], by_1[0], by_1[1], by_1[2]]
    L = _cholesky(H)
    y = _forward(L, work)
    # b7, b6, b5, the mean resultants, because the means of x and of y are zero
    N = [y[6] / L[6][6]]
    N.append((y[5] - L[6][5] * N[0]) / L[5][5])
    N.append((y[4] - L[6][4] * N[0] - L[5][4] * N[1]) / L[4][4])
    k = sum(
        (p.weight * k for p, k in zip(q.points, curvature, strict=True)), as_vector((0.0, 0.0, 0.0))
    )
    strain = flexible * (as_vector(N[::-1]) - q.B * (k / q.area))
    whole = as_vector(y)
    return Hybrid([(whole, whole), *_steadying(q)], strain)


def _moment(q: Cell, curvature: list[Any], factor: list[Any], bow: Any) -> Any:
    """int factor (e + A^-1 B k), with the bow of the sides."""
    stretched = bent = as_vector((0.0, 0.0, 0.0))
    for point, f, k in zip(q.points, factor, curvature, strict=True):
        e = linear_strain(point, q.feet) + bow * bow_strain(q, point)
        stretched += point.weight * f * e
        bent += point.weight * f * k
    return stretched + inv(q.A) * q.B * bent


def _field(q: Cell, point: Point) -> list[Any]:
    """Columns of P at a point, with x and y in units of the cell's size, so that all are alike."""
    x, y = (point.xy[i] / sqrt(q.area) for i in range(2))
    columns = [(y, 0.0, 0.0), (0.0, x, 0.0), (x, 0.0, -y), (0.0, y, -x),
               (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]  # fmt: skip
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


CURVED, SHEARED, ANSWER = 16.0 / 5.0, 32.0 / 105.0, -2.0 / 5.0


def relief(q: Cell, shear: list[Any]) -> list[tuple[Any, Any]]:
    """Stiffness that the internal rotations take from the plate: negative pairs.

    Parameters
    ----------
    shear : shear strain at the points of the cell
    """
    D = q.D - q.B * inv(q.A) * q.B  # with free membrane resultants
    at, pairs = q.mapping, []
    for along, gradient, across in ((at.by_xi, at.grad_eta, 1), (at.by_eta, at.grad_xi, 0)):
        t = along / sqrt(dot(along, along))
        k = as_vector(
            (t[0] * gradient[0], t[1] * gradient[1], t[0] * gradient[1] + t[1] * gradient[0])
        )
        own = CURVED * dot(k, D * k) + SHEARED * dot(t, q.Ds * t)
        places = GAUSS[:, across].tolist()
        work = sum(s * dot(q.Ds * t, gamma) for s, gamma in zip(places, shear, strict=True))
        answer = as_vector([ANSWER * work])
        pairs.append((-abs(at.det) / own * answer, answer))
    return pairs
