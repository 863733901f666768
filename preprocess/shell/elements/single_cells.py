"""Data, matrices, rows and resultants of single cells, from the pairs that DOLFINx assembles.

Kernels read the data of a cell from one row of numbers. Corners run around the cell here, as
everywhere but in DOLFINx.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ... import fenicsx
from ...laminate.stiffness import LaminateStiffness
from ..shell_cells import CellGeometry
from .cell import AROUND, COLUMNS, SIZE
from .membranes import MEMBRANES
from .membranes.opt import best_beta0
from .pairs import Choice, stiffness_kernel


def cell_table(geometry: CellGeometry, laminate: LaminateStiffness, choice: Choice) -> Array:
    """The table (c, SIZE) of cells; entries of a prestress, a pressure, and of the mass of a
    laminate without density are zero.

    Parameters
    ----------
    laminate : A, B, D, Ds in E, the first axis c or 1 is optional
    """
    table = np.zeros((len(geometry), SIZE))
    best = isinstance(choice.beta0, str)
    beta0 = best_beta0(np.reshape(laminate.A, (-1, 3, 3))) if best else choice.beta0
    write(table, A_GE=geometry.A_GE, beta0=beta0, drilling_factor=choice.drilling_factor)
    write(table, A=laminate.A, B=laminate.B, D=laminate.D, Ds=laminate.Ds)
    write(table, mass=getattr(laminate, "mass", np.zeros(3)))
    if geometry.xy_E.shape[1] == 4:
        write(table, bow=MEMBRANES[choice.membrane].bow, width_ratio=geometry.width_ratio)
    return table


def write(table: Array, **entries: Any) -> None:
    """Write entries by name, one for all cells or one for each."""
    for name, values in entries.items():
        first, shape = COLUMNS[name]
        size = int(np.prod(shape, dtype=int))
        table[:, first : first + size] = np.reshape(values, (-1, size))


def cell_matrices(t: CellGeometry, kernel: fenicsx.Kernel, table: Array) -> Array:
    """Matrices of cells in G, (c, 6 k, 6 k).

    Parameters
    ----------
    t : c cells with k corners
    kernel : of such cells
    table : (c, columns) of `cell_table`
    """
    corners, order = _as_dolfinx(t)
    return fenicsx.matrices(kernel, table, corners)[:, order[:, None], order]


def cell_rows(
    t: CellGeometry, kernel: fenicsx.Kernel, table: Array
) -> list[tuple[Array, Array, Array]]:
    """Stresses and strains (c, p, 6 k) of pairs, and mean strains (c, n, 6 k), of each list of a
    kernel, per unit of the unknowns in G.

    Parameters
    ----------
    t : c cells with k corners
    kernel : of such cells
    table : (c, columns) of `cell_table`
    """
    rows_of_cells, (corners, order) = [], _as_dolfinx(t)
    for number, given in enumerate(kernel.lists):
        rows, p = fenicsx.rows(kernel, number, table, corners)[:, :, order], given.pairs
        rows_of_cells.append((rows[:, :p], rows[:, p : 2 * p], rows[:, 2 * p + given.coupling :]))
    return rows_of_cells


def _as_dolfinx(t: CellGeometry) -> tuple[Array, IntArray]:
    """Corners (c, k, 3) in DOLFINx's order, from the centroid, for strains do not depend on the
    place; its unknown for each one around the cell. The order is its own inverse."""
    around = np.array(AROUND[t.xy_E.shape[1]])
    unknowns = (6 * around[:, None] + np.arange(6)).ravel()
    return np.ascontiguousarray(t.corners_G[:, around]), unknowns


AT_A_TIME = 512  # cells whose rows are in memory together


def mean_strain_rows(
    t: CellGeometry, laminate: LaminateStiffness, choice: Choice
) -> Iterator[tuple[slice, Array]]:
    """Some cells at a time, with their mean strains per unit of the unknowns in G, (s, 8, 6 k).

    Parameters
    ----------
    t : c triangles or quadrilaterals
    laminate : A, B, D, Ds in E, one for all or one for each cell
    choice : the elements
    """
    kernel = stiffness_kernel(t.xy_E.shape[1], choice, drilling=False)
    table = cell_table(t, laminate, choice)
    for first in range(0, len(t), AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        means = [mean for _, _, mean in cell_rows(t[some], kernel, table[some])]
        yield some, np.concatenate(means, axis=1)


def element_strains(
    t: CellGeometry, laminate: LaminateStiffness, choice: Choice, u_G: Array
) -> Array:
    """Mean strains of each element in E, (c, 8, m): exx eyy gxy, kxx kyy kxy [1/m], gxz gyz.

    Parameters
    ----------
    t : c triangles or quadrilaterals
    laminate : A, B, D, Ds in E, one for all or one for each cell
    choice : the elements
    u_G : (c, 18|24, m) displacements [m] and rotations [rad] of the corners, m states at once

    Raises
    ------
    ShellError
        for a choice that does not exist
    """
    strains = np.empty((len(t), 8, u_G.shape[2]))
    for some, rows in mean_strain_rows(t, laminate, choice):
        strains[some] = rows @ u_G[some]
    return strains


def element_resultants(
    t: CellGeometry, laminate: LaminateStiffness, choice: Choice, u_G: Array
) -> Array:
    """Mean resultants of each element in E, (c, 8, m): N [N/m] 3, M [N] 3, T [N/m] 2.

    Order N_xx N_yy N_xy, M_xx M_yy M_xy, T_x T_y.

    Paper: Eq. (28).

    Parameters
    ----------
    t, laminate, choice, u_G : as of `element_strains`, which raises the same errors
    """
    A, B, D = (np.reshape(a, (-1, 3, 3)) for a in (laminate.A, laminate.B, laminate.D))
    strains = element_strains(t, laminate, choice, u_G)
    e, k, gamma = strains[:, :3], strains[:, 3:6], strains[:, 6:]
    return np.concatenate([A @ e + B @ k, B @ e + D @ k, laminate.Ds @ gamma], axis=1)
