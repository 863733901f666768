"""Membrane elements (flat triangles): one file per element, all with the same interface.

    f(t: Triangles, A (c|1, 3, 3) [N/m], beta0) -> MembraneStrains

in the membrane's degrees of freedom (u, v, tz) of corners 1, 2, 3. Only "opt" uses `beta0`.
"""

from collections.abc import Callable

from ....solver.math.arrays import Array
from ..triangles import Triangles
from .allman import allman
from .cst import cst
from .opt import opt
from .strains import MembraneStrains

Membrane = Callable[[Triangles, Array, float | str], MembraneStrains]

MEMBRANES: dict[str, Membrane] = {"opt": opt, "allman": allman, "cst": cst}
WITH_ROTATIONS = frozenset({"opt", "allman"})  # membranes with stiffness for tz

__all__ = ["MEMBRANES", "WITH_ROTATIONS", "Membrane", "MembraneStrains"]
