"""Data of cells as DOLFINx's kernels read them: one row of numbers for each cell."""

from typing import Any, Protocol

import numpy as np

from ....solver.math.arrays import Array
from ..mesh.quadrilaterals import Quadrilaterals
from ..mesh.triangles import Triangles
from .cell import COLUMNS, SIZE
from .choice import Choice
from .membranes import MEMBRANES
from .membranes.opt import best_beta0


class Stiffness(Protocol):
    """Laminate data that an element needs, in E; the first axis c or 1 is optional."""

    @property
    def A(self) -> Array:
        """Membrane, (3, 3) [N/m]."""

    @property
    def B(self) -> Array:
        """Coupling, (3, 3) [N]."""

    @property
    def D(self) -> Array:
        """Bending, (3, 3) [N m]."""

    @property
    def Ds(self) -> Array:
        """Transverse shear, corrected, (2, 2) [N/m]."""


def cell_table(geometry: Triangles | Quadrilaterals, laminate: Stiffness, choice: Choice) -> Array:
    """The table (c, SIZE) of cells; entries of a prestress, a pressure, and of the mass of a
    laminate without density are zero.

    Parameters
    ----------
    laminate : one for all or one for each cell
    """
    table = np.zeros((len(geometry), SIZE))
    beta0: Array | float
    if isinstance(choice.beta0, str):
        beta0 = best_beta0(np.reshape(laminate.A, (-1, 3, 3)))
    else:
        beta0 = choice.beta0
    write(table, A_GE=geometry.A_GE, beta0=beta0, drilling_factor=choice.drilling_factor)
    write(table, A=laminate.A, B=laminate.B, D=laminate.D, Ds=laminate.Ds)
    write(table, mass=getattr(laminate, "mass", np.zeros(3)))
    if isinstance(geometry, Quadrilaterals):
        write(table, bow=MEMBRANES[choice.membrane].bow, width_ratio=geometry.width_ratio)
    return table


def write(table: Array, **entries: Any) -> None:
    """Write entries by name, one for all cells or one for each."""
    for name, values in entries.items():
        first, shape = COLUMNS[name]
        size = int(np.prod(shape, dtype=int))
        table[:, first : first + size] = np.reshape(values, (-1, size))
