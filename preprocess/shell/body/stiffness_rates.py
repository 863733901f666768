"""Derivatives of the modal stiffness of a shell by the entries of A, B and D of its laminates."""

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.body.lay_ups import ENTRIES
from ..elements.pairs import stiffness_kernel
from ..elements.single_cells import AT_A_TIME, cell_matrices, cell_table, write
from ..model.shell_problem import ShellProblem
from ..shell_cells import DOFS


def not_linear(problem: ShellProblem) -> str:
    """Why the stiffness of a shell is not linear in A, B and D alone, or nothing."""
    choice = problem.choice
    if problem.mesh.cells.shape[1] == 4:
        return "the membrane of quadrilaterals depends on the inverse of A"
    if choice.plate != "dkt":
        return f"elements.plate = {choice.plate} depends on the transverse shear stiffness too"
    if isinstance(choice.beta0, str):
        return f"elements.beta0 = {choice.beta0} depends on ratios of A"
    if any(link.kind == "section" for link in problem.links):
        return "motions of links to sections depend on the laminates"
    return ""


def stiffness_rates(problem: ShellProblem, u: Array) -> dict[str, Array]:
    """Derivatives (18, m, m) by the name of a laminate, of A, B, D in the order of ENTRIES.

    Parameters
    ----------
    problem : a shell for which `not_linear` has no reason
    u : (n_dof, m) motion of all degrees of freedom in the modes
    """
    m = u.shape[1]
    rates: dict[str, Array] = {r.laminate_name: np.zeros((18, m, m)) for r in problem.regions}
    kernel, rows = stiffness_kernel(3, problem.choice), u.reshape(-1, DOFS, m)
    for number, region in enumerate(problem.regions):
        moved = rows[region.nodes].reshape(len(region.cells), 3 * DOFS, m)
        if problem.beside is not None:
            moved = problem.beside.moved(number, moved, u)
        for first in range(0, len(region.cells), AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            part, corners = region.geometry[some], moved[some]
            table = cell_table(part, region.stiffness, problem.choice)
            for row in range(18):
                unit = np.zeros((3, 3, 3))
                n, (i, j) = row // 6, ENTRIES[row % 6]
                unit[n, i, j] = unit[n, j, i] = 1.0
                write(table, A=unit[0], B=unit[1], D=unit[2])
                work = cell_matrices(part, kernel, table) @ corners
                rates[region.laminate_name][row] += np.tensordot(corners, work, ((0, 1), (0, 1)))
    return rates
