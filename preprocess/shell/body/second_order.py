"""Second-order displacements of the modes of a shell, from its geometric stiffness.

With Kg(v) the geometric stiffness of the resultants of displacements v, the second-order strains of
two modes X_i, X_j do the work X_i' Kg(v) X_j = g_ij . v on the stresses of v. The second-order
displacement h_ij cancels them as far as the shell can,

    K h_ij = -g_ij     in the reference condition of the modes.

For any load f then f . h_ij = -X_i' Kg(K^-1 f) X_j (docs/stiffening.md). The nodes of a rigid
interface turn with it: to second order they also move by
(a_i x (a_j x d) + a_j x (a_i x d))/2 with the rotations a of the interface and the arms d. The
strains that h cannot cancel, where edges are held in the plane or the shell bends in two
directions, would add an energy of fourth order, which is neglected.
"""

from typing import NamedTuple

import numpy as np

from ....solver.math.arrays import Array, IntArray
from ...modes.reduced import pairs, square, turned
from ...modes.reference import Condition, StaticShapes
from ..elements.pairs import Choice, geometric_kernel
from ..elements.single_cells import cell_rows, cell_table, mean_strain_rows, write
from ..model.freedom import Freedom
from ..model.regions import Region
from ..model.shell_problem import ShellProblem
from ..shell_cells import DOFS


class Near(NamedTuple):
    """The second-order motion of a shell, from which that of a changed one is found to first order.

    Attributes
    ----------
    condition : reference condition of the shell
    columns : (n_free, pairs) second-order motion of its independent degrees of freedom
    """

    condition: Condition
    columns: Array


def second_order_fields(
    problem: ShellProblem, condition: Condition, u: Array, near: Near | None = None
) -> Array:
    """Second-order motion of all degrees of freedom, (n_dof, m, m) [m, rad].

    Parameters
    ----------
    condition : reference condition of the modes, in the independent degrees of freedom
    u : (n_dof, m) motion of all degrees of freedom in the modes
    near : to solve with the matrix of a shell that is nearly the same
    """
    moved = _turned_interfaces(problem.freedom, u)
    columns = second_order_columns(problem, condition, u, near)
    return square(problem.freedom.expanded(columns) + moved, u.shape[1])


def second_order_columns(
    problem: ShellProblem, condition: Condition, u: Array, near: Near | None = None
) -> Array:
    """The part of `second_order_fields` that is solved for, (n_free, pairs).

    Parameters
    ----------
    problem : the shell
    condition, u, near : as of `second_order_fields`
    """
    moved = _turned_interfaces(problem.freedom, u)
    loads = -problem.freedom.gathered(pair_forces(problem, u) + problem.K @ moved)
    zero = np.zeros_like(loads)
    if near is None:
        return condition.static(loads, zero).columns
    # one step of Newton: round-off of the solution is that of a small difference
    loads = condition.load_rates(StaticShapes(zero, zero, zero), 0.0 * condition.M, loads, zero)[1]
    step = near.condition.static(loads - condition.K @ near.columns, zero).columns
    change = condition.M - near.condition.M
    return near.columns + step + near.condition.relief(change @ near.columns)


def pair_forces(problem: ShellProblem, u: Array) -> Array:
    """Forces g (n_dof, pairs): v . g is the work of the stresses of v on the strains of a pair."""
    first, second = pairs(u.shape[1])
    g = np.zeros((problem.freedom.n_dof, len(first)))
    for number, region in enumerate(problem.own):
        forces = _add_region(g, region, problem.choice, u, first, second)
        if problem.beside is not None:
            rows, change = problem.beside.rows[number], problem.beside.change[number]
            g += change.T @ forces[rows].reshape(change.shape[0], -1)
    for stiffener in problem.stiffeners:
        force, turn = stiffener.axial_force, stiffener.chord_rotation
        size = force.shape[1]
        own = (turn @ u[:size]).reshape(force.shape[0], 3, -1)
        work = np.einsum("l,lap,lap->lp", stiffener.length, own[..., first], own[..., second])
        g[:size] += force.T @ work
    return g


def _add_region(
    g: Array, region: Region, choice: Choice, u: Array, first: IntArray, second: IntArray
) -> Array:
    """Add R' c_ij of its cells: N = R v, and c_ij the second-order strains over the area.

    Returns them on the corners, (c, 6 k, pairs).
    """
    rows = u.reshape(-1, DOFS, u.shape[1])
    k = region.nodes.shape[1]
    geometric = geometric_kernel(k)
    A, B = region.stiffness.A, region.stiffness.B
    table = cell_table(region.geometry, region.stiffness, choice)
    # the work of this tension is that of w,x^2 + w,y^2 + 2 r^2
    write(table, N=np.array([1.0, 1.0, 0.0]), in_plane=1.0)
    strains_of_cells = np.empty((len(region.cells), DOFS * k, len(first)))
    for some, strain in mean_strain_rows(region.geometry, region.stiffness, choice):
        part, nodes = region.geometry[some], region.nodes[some]
        R = A @ strain[:, :3] + B @ strain[:, 3:6]
        ((stress, slope, _),) = cell_rows(part, geometric, table[some])
        own = rows[nodes].reshape(len(nodes), DOFS * k, -1)
        # (c, points, 3, m): w,x w,y r, the first times the area of their points
        by_area, plain = ((a @ own).reshape(len(nodes), -1, 3, u.shape[1]) for a in (stress, slope))
        by_area[:, :, 2] *= 0.5
        one, other = by_area[..., first], plain[..., second]
        spun = one[:, :, 2] * other[:, :, 2]
        c = np.stack(
            [
                one[:, :, 0] * other[:, :, 0] + spun,
                one[:, :, 1] * other[:, :, 1] + spun,
                one[:, :, 0] * other[:, :, 1] + one[:, :, 1] * other[:, :, 0],
            ],
            axis=2,
        )
        strains = c.sum(axis=1)  # (c, 3, pairs)
        strains_of_cells[some] = np.swapaxes(R, 1, 2) @ strains
        dofs = (DOFS * nodes[:, :, None] + np.arange(DOFS)).ravel()
        np.add.at(g, dofs, strains_of_cells[some].reshape(-1, len(first)))
    return strains_of_cells


def _turned_interfaces(freedom: Freedom, u: Array) -> Array:
    """Second-order motion of the nodes of rigid interfaces with respect to them, (n_dof, pairs)."""
    out = np.zeros((len(u) // DOFS, DOFS, len(pairs(u.shape[1])[0])))
    rows = u.reshape(-1, DOFS, u.shape[1])
    n_node = freedom.mesh.n_node
    for number, link in enumerate(freedom.links):
        if link.kind != "rigid":
            continue
        arms = freedom.mesh.points_G[link.group.nodes] - link.point_G
        out[link.group.nodes, :3] = turned(rows[n_node + number, 3:], arms)
    return out.reshape(len(u), -1)
