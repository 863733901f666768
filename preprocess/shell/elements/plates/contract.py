"""Contract of a plate: what its file supplies.

A plate is one file of this folder with an object of class `Plate`, and a line in `PLATES` of
solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
CONTRIBUTING.md has the recipe.

    strains(t) -> PlateStrains

    t    a flat triangle in its own axes E, with its laminate, in UFL (cell.py)

gives curvature and shear strain, linear in the unknowns (w, bx, by) of corners [m, rad]: w the
deflection along e3, (bx, by) the rotation of the normal, u = z bx and v = z by. A rigid motion has
no strain.

Common part of the plates: rotations with a quadratic tangential part on each side.

With functions N_i of the corners, P_k of the sides (1 in the middle of side k from corner i to j
of length L_k and unit tangent t_k), the rotation b = (bx, by) of the normal is

    b = sum_i N_i b_i + sum_k P_k t_k alpha_k,

linear along a side in the direction normal to it, quadratic along it. Integrated along a side, the
shear strain gamma_s = w,s + t.b is

    L_k mean(gamma_s) = w_j - w_i + (L_k/2) t_k.(b_i + b_j) + (2/3) L_k alpha_k
                      = -Aw_k + (2/3) L_k alpha_k.                                     (side)

Each plate adds its own condition on gamma_s, which gives alpha. All is for triangles and for
quadrilaterals.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ufl import as_vector

from ..cell import Cell, Point


class PlateStrains(NamedTuple):
    """Strains of a plate in E, linear in its unknowns (w, bx, by).

    Paper: Eq. (27).

    Attributes
    ----------
    curvature : (kxx, kyy, kxy) [1/m] at the points of the cell
    shear : (gxz, gyz) at the points, or one value where it is constant, or none
    """

    curvature: list[Any]
    shear: list[Any]


def side_differences(t: Cell) -> list[Any]:
    """Aw_k = w_i - w_j - (L_k/2) t_k.(b_i + b_j) [m] of each side."""
    differences = []
    for (i, j), L, (C, S) in zip(t.sides, t.length, t.tangent, strict=True):
        a, b = t.corners[i], t.corners[j]
        differences.append(a.w - b.w - 0.5 * L * (C * (a.bx + b.bx) + S * (a.by + b.by)))
    return differences


def curvature(t: Cell, alpha: list[Any] | None) -> list[Any]:
    """Curvature at the points of the cell; alpha None: the rotations have no P_k."""
    return [_curvature(t, point, alpha) for point in t.points]


def _curvature(t: Cell, point: Point, alpha: list[Any] | None) -> Any:
    bx, by = (point.slope([getattr(corner, name) for corner in t.corners]) for name in ("bx", "by"))
    k = as_vector((bx[0], by[1], bx[1] + by[0]))
    for p, (C, S), a in zip(point.bulges, t.tangent, alpha or [], strict=alpha is not None):
        k += a * as_vector((C * p[0], S * p[1], C * p[1] + S * p[0]))
    return k


def edge_shear(t: Cell, side: list[Any]) -> list[Any]:
    """Shear strain at the points with a given constant tangential value on each side: the edge
    interpolation of lowest order."""
    return [
        sum(
            (gamma * field for gamma, field in zip(side[1:], point.edges[1:], strict=True)),
            side[0] * point.edges[0],
        )
        for point in t.points
    ]


def shear_ratio(D: Any, Ds: Any, tangent: Any, length: Any) -> Any:
    """Ratio of shear flexibility to bending flexibility of a side.

    phi = 12 D_ss / (Ds_ss L^2) with D_ss = q' D q, q = (C^2, S^2, 2 C S) the moment about the
    side's normal for a unit curvature along the side, and Ds_ss = t' Ds t. Isotropic:
    2 / (kappa (1 - nu)) (h / L)^2.

    Parameters
    ----------
    D, Ds : bending [N m] and transverse shear stiffness [N/m], by [i, j]
    tangent, length : (C, S) and L [m]
    """
    C, S = tangent[0], tangent[1]
    q, t = (C * C, S * S, 2.0 * C * S), (C, S)
    D_ss = sum(q[i] * D[i, j] * q[j] for i in range(3) for j in range(3))
    Ds_ss = sum(t[i] * Ds[i, j] * t[j] for i in range(2) for j in range(2))
    return 12.0 * D_ss / (Ds_ss * length**2)


def side_ratios(t: Cell) -> list[Any]:
    """`shear_ratio` of each side, of quadrilaterals with the part of the width."""
    ratios = []
    for k in range(t.k):
        phi = shear_ratio(t.D, t.Ds, t.tangent[k], t.length[k])
        if t.k == 4:
            width = phi * t.width_ratio[k]
            phi = phi + width + width**2
        ratios.append(phi)
    return ratios


@dataclass(frozen=True)
class Plate:
    """Bending and transverse shear of a flat triangle.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : see above
    shear_ratio_limit : `shear_ratio` of a side above which the element does not
        converge: a warning; None: it always does
    """

    name: str
    strains: Callable[[Cell], PlateStrains]
    shear_ratio_limit: float | None = None
