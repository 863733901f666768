"""Coupling of the drilling rotations to the rotation of the triangle (Hughes and Brezzi 1989)."""

from typing import Any

from ufl import as_vector

from ..cell import Cell
from .contract import Drilling


def tie(t: Cell) -> list[tuple[Any, Any]]:
    """Stiffness of the energy factor A66/2 int (tz - (v,x - u,y)/2)^2, tz and u, v linear.

    Only rigid motions have no energy: it adds no zero-frequency mode.
    """
    factor, pairs = t.drilling_factor * t.A[2, 2], []
    for point in t.points:
        th = as_vector([point.of(t.excess(t.corners))])
        pairs.append((factor * point.weight * th, th))
    return pairs


DRILLING = Drilling("tie", tie)
