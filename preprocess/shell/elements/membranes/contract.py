"""Contract of a membrane: what its file supplies.

A membrane is one file of this folder with an object of class `Membrane`, and a line in `MEMBRANES`
of solver/package/shell/elements.py, the source of the names in descriptions and in their manual.
CONTRIBUTING.md has the recipe.

    strains(t) -> MembraneStrains

    t    a flat triangle in its own axes E, with its laminate, in UFL (cell.py)

gives strain, linear in the unknowns (u, v, tz) of corners [m, rad], tz the rotation about e3, and
pairs of stiffness in addition to that of the strain. Both are zero for a rigid motion. Common to
several membranes is the strain of displacements that may bow along the sides.
"""

from collections.abc import Callable
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Membrane:
    """Membrane of a flat triangle.

    Attributes
    ----------
    name : in `[elements]` of a shell description
    strains : see above
    rotations : True if it gives stiffness to tz; otherwise `drilling` does
    bow : mean distance of a side of length L from its chord is bow L/12 (tz_j - tz_i), with an
     effect on loads along the side; 0: straight sides
    stiff_in_plane : True if it is far too stiff in in-plane bending of a narrow wall: a warning
    """

    name: str
    strains: Callable[[Cell], MembraneStrains]
    rotations: bool
    bow: float = 0.0
    stiff_in_plane: bool = False
