"""Derivatives of the modal stiffness of a shell by the entries of A, B and D of its laminates."""

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.body.lay_ups import ENTRIES
from ..elements.pairs import stiffness_kernel
from ..elements.single_cells import AT_A_TIME, cell_matrices, cell_table, write
from ..model.shell_problem import ShellProblem
from ..shell_cells import DOFS


def is_linear(problem: ShellProblem) -> bool:
    """True if the stiffness of a shell is linear in A, B and D, and depends on nothing else.

    Transverse shear depends on a ratio of D to Ds, quadrilaterals and a `beta0` from the laminate
    on A^-1; links to sections and cells at stiffeners follow the laminates.
    """
    return (
        problem.mesh.cells.shape[1] == 3
        and problem.choice.plate == "dkt"
        and not isinstance(problem.choice.beta0, str)
        and not problem.stiffeners
        and all(link.kind != "section" for link in problem.links)
    )


def stiffness_rates(problem: ShellProblem, u: Array) -> dict[str, Array]:
    """Derivatives (18, m, m) by the name of a laminate, of A, B, D in the order of ENTRIES.

    Parameters
    ----------
    problem : a shell for which `is_linear`
    u : (n_dof, m) motion of all degrees of freedom in the modes
    """
    m = u.shape[1]
    rates: dict[str, Array] = {r.laminate_name: np.zeros((18, m, m)) for r in problem.regions}
    kernel, rows = stiffness_kernel(3, problem.choice), u.reshape(-1, DOFS, m)
    for region in problem.regions:
        for first in range(0, len(region.cells), AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            part = region.geometry[some]
            corners = rows[region.nodes[some]].reshape(len(part), 3 * DOFS, m)
            table = cell_table(part, region.stiffness, problem.choice)
            for row in range(18):
                unit = np.zeros((3, 3, 3))
                n, (i, j) = row // 6, ENTRIES[row % 6]
                unit[n, i, j] = unit[n, j, i] = 1.0
                write(table, A=unit[0], B=unit[1], D=unit[2])
                work = cell_matrices(part, kernel, table) @ corners
                rates[region.laminate_name][row] += np.tensordot(corners, work, ((0, 1), (0, 1)))
    return rates
