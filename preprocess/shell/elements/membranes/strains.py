"""Common part of the membranes: the strain of displacements that may bow along the sides."""

from typing import Any, NamedTuple

from ufl import as_vector

from ..cell import Cell, Corner, Point


class MembraneStrains(NamedTuple):
    """Strains of a membrane in E, linear in its unknowns (u, v, tz).

    Paper: Eq. (27).

    Attributes
    ----------
    strain : (exx, eyy, gxy) [1/m] at the points of the cell, or one value where it is constant
    extra : pairs (stress, strain), vectors, of motions not in this strain, of the whole cell
    """

    strain: list[Any]
    extra: list[tuple[Any, Any]]


def linear_strain(point: Point, corners: list[Corner]) -> Any:
    """Strain of the displacements sum_i N_i (u_i, v_i), independent of tz."""
    u, v = (point.slope([getattr(corner, name) for corner in corners]) for name in ("u", "v"))
    return as_vector((u[0], v[1], u[1] + v[0]))


def bow_strain(t: Cell, point: Point) -> Any:
    """Strain of sides displaced from their chords by P_k (L_k/8)(tz_j - tz_i) n_k.

    n_k = (t_y, -t_x).
    """
    e = as_vector((0.0, 0.0, 0.0))
    for (i, j), L, (C, S), p in zip(t.sides, t.length, t.tangent, point.bulges, strict=True):
        bow = L / 8.0 * (t.corners[j].tz - t.corners[i].tz)
        e += bow * as_vector((S * p[0], -C * p[1], S * p[1] - C * p[0]))
    return e
