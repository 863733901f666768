"""Stiffness of the rotation about the normal: one file per form, all with the same interface.

    f(t: Triangles, A (c|1, 3, 3) [N/m], factor) -> (c, 9, 9)

in the membrane's degrees of freedom (u, v, tz) of corners 1, 2, 3.
"""

from collections.abc import Callable

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .fictitious import fictitious
from .tie import tie

Drilling = Callable[[Triangles, Array, float], Array]

DRILLINGS: dict[str, Drilling] = {"fictitious": fictitious, "tie": tie}

__all__ = ["DRILLINGS", "Drilling"]
