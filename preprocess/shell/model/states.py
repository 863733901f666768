"""Warnings about solved states of a shell: cells that lock, and links that distort an open end.

The normal of a flat cell is tilted against that of the surface at its corners. Where the surface is
saddle-shaped, a dome or twisted, a rotation of bending has a component along the normal of the
cell, which its membrane resists as a rotation in its plane. The work of the membranes on these
components alone, over that of the whole shell, is about the relative error of the strain energy by
this locking (docs/shells-accuracy.md). Triangles lock on any such surface; quadrilaterals need
cells some times larger to do so, and do not where two of their lines follow its twist.

The forces of an average link have a part normal to the walls, those of a section link are the
stresses far from the end of a member that twists evenly. Where they do not suit the section, they
deform the walls near the end. With the nodal forces F of the link and G of the other kind, both of
unit resultants, the point moves by F'u, of which F'K^-1 G is free of the local deformation of both
(Saint-Venant: F - G has no resultant). G'u is therefore the motion of the section, and
f.(F'u - G'u) the work of the load f on its distortion (docs/shells.md).
"""

from collections.abc import Sequence

import numpy as np

from ....solver.errors import coded
from ....solver.math.arrays import Array
from ....solver.package.specification import DIRECTIONS
from ..elements.membranes import MEMBRANES
from ..elements.pairs import stiffness_kernel
from ..elements.single_cells import cell_matrices, cell_table, write
from ..shell_cells import DOFS, ShellError
from .links import Link, averaged, section_rows
from .shell_problem import ShellProblem
from .shell_warnings import Warnings

LOCKED = 0.1  # of the strain energy, about its error, that is warned about
ADVISED = 0.05  # the same on the mesh that the message advises
ORDER = 4.0  # share/(1 - share) of quadrilaterals falls with this power of their size, or faster
FOLD = 0.98  # cosine between the normals of a cell and of a node below which there is a fold
TILTED = 1e-3  # sine of the tilt above which a cell counts
AT_A_TIME = 4096  # cells whose matrices are in memory together


def warped_warnings(problem: ShellProblem, u: Array, names: Sequence[str]) -> Warnings:
    """A warning if cells lock in one of some states.

    Parameters
    ----------
    problem : the shell
    u : (n_dof, m) displacements of the states
    names : what each state is, such as "mode 1"
    """
    kinds = tilted_work(problem, u)
    share = kinds.sum(axis=0)
    bad = np.flatnonzero(share > LOCKED)
    if not bad.size:
        return []
    worst = bad[np.argmax(share[bad])]
    more = "" if bad.size == 1 else f" and {bad.size - 1} more"
    quads = kinds[1, worst] > kinds[0, worst]
    kind = "quadrilaterals" if quads else "triangles"
    advice = 'use element = "quadrilateral" in [mesh], smaller cells, or both'
    if quads:
        locked, right = min(share[worst], 0.95), ADVISED
        times = (locked / (1.0 - locked) * (1.0 - right) / right) ** (1.0 / ORDER)
        advice = (
            f"use cells about {np.ceil(10.0 * times) / 10.0:.1f} times smaller in the mesh file or "
            "its script, with nodes on the curved surface"
        )
    text = (
        f"{names[worst]}{more}: {kind} are too large for the thickness of this warped surface, "
        "and the shell is too stiff: rotations of bending that are tilted into their planes take "
        f"{100.0 * share[worst]:.0f} % of the strain energy, which is about its error; {advice}"
    )
    if quads:
        return coded("shell-quadrilaterals-warped", text)
    return coded("shell-triangles-warped", text)


def tilted_work(problem: ShellProblem, u: Array) -> Array:
    """Work of the membranes on rotations that cells see because of their tilt.

    In a cell with normal e3, corner i has the tilt t_i = e3 - (e3.n_i) n_i, n_i the normal of the
    surface at the node. The work is that of the moments about e3, of the whole membrane, on the
    rotations t_i.th_i, th_i those of the corner less their mean over the cell. Corners at folds do
    not count.

    Parameters
    ----------
    u : (n_dof, m) states

    Returns
    -------
    (2, m), of triangles and of quadrilaterals, over twice the strain energy of the shell; 0 for a
    state without strain energy
    """
    count = u.shape[1]
    work = np.zeros((2, count))
    if not count or not MEMBRANES[problem.choice.membrane].rotations:
        return work
    normal, smooth = _normals(problem)
    nodal = u.reshape(-1, 6, count)
    for region in problem.regions:
        geometry = region.geometry
        k = region.nodes.shape[1]
        kernel = stiffness_kernel(k, problem.choice, drilling=False)
        table = cell_table(geometry, region.stiffness, problem.choice)
        write(table, B=np.zeros((3, 3)))  # moments about e3 are those of the membrane alone
        e3, n = geometry.A_GE[:, :, 2], normal[region.nodes]
        tilt = e3[:, None] - np.einsum("ci,cki->ck", e3, n)[..., None] * n
        tilt *= smooth[region.nodes][..., None]
        cells = np.flatnonzero(np.linalg.norm(tilt, axis=2).max(axis=1) > TILTED)
        for first in range(0, len(cells), AT_A_TIME):
            some = cells[first : first + AT_A_TIME]
            corners = nodal[region.nodes[some]]
            turned = corners[:, :, 3:] - corners[:, :, 3:].mean(axis=1, keepdims=True)
            about = np.einsum("cki,ckim->ckm", tilt[some], turned)
            K = cell_matrices(geometry[some], kernel, table[some])
            forces = (K @ corners.reshape(len(some), 6 * k, count)).reshape(-1, k, 6, count)
            moments = np.einsum("ci,ckim->ckm", e3[some], forces[:, :, 3:])
            work[k - 3] += np.einsum("ckm,ckm->m", about, moments)
    energy = np.einsum("nm,nm->m", u, problem.team.total(problem.K @ u))
    return np.divide(work, energy, out=np.zeros_like(work), where=energy > 0.0)


def _normals(problem: ShellProblem) -> tuple[Array, Array]:
    """Unit normals of the surface at the nodes (n, 3), and 0 at folds, 1 elsewhere (n,)."""
    total = np.zeros((problem.mesh.n_node, 3))
    for region in problem.regions:
        e3 = region.geometry.A_GE[:, :, 2] * region.geometry.area[:, None]
        np.add.at(total, region.nodes, e3[:, None])
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normal = np.divide(total, length, out=np.zeros_like(total), where=length > 0.0)
    smooth = np.ones(len(normal))
    for region in problem.regions:
        along = np.einsum("ci,cki->ck", region.geometry.A_GE[:, :, 2], normal[region.nodes])
        smooth[region.nodes[along < FOLD]] = 0.0
    return normal, smooth


DISTORTED = 0.1  # motion of the point beyond that of the section, over the latter
OF_ALL = 0.01  # least share of the strain energy of the shell
OTHER = {"average": "section", "section": "average"}


def link_warnings(
    problem: ShellProblem, u: Array, forces: Array, energy: Array, names: Sequence[str]
) -> Warnings:
    """Warnings about links whose loads distort the end that they act on.

    Parameters
    ----------
    u, forces : (n_dof, m) displacements and loads of load cases
    energy : (m,) their strain energy
    """
    warnings: Warnings = []
    for number, link in enumerate(problem.links):
        dofs = DOFS * (problem.mesh.n_node + number) + np.arange(DOFS)
        load, moved = forces[dofs], u[dofs]
        if not load.any() or (rows := _other_rows(problem, link)) is None:
            continue
        section = _motion(problem, link, rows, u)
        work = np.einsum("im,im->m", load, section)
        excess = np.einsum("im,im->m", load, moved) - work
        ratio = excess / np.where(work != 0.0, np.abs(work), np.inf)
        bad = np.flatnonzero((ratio > DISTORTED) & (excess > 2.0 * OF_ALL * energy))
        if bad.size:
            worst = bad[np.argmax(ratio[bad])]
            warnings += _told(f"load case {names[worst]}", link, float(ratio[worst]), "kind")
    return warnings


def interface_warnings(
    problem: ShellProblem, u: Array, values: Array, attachments: Sequence[tuple[str, str]]
) -> Warnings:
    """The same of the attachment modes of a body.

    Parameters
    ----------
    u, values : (n_dof, m) modes of unit modal mass, squared circular frequencies (m,)
    attachments : interface and direction of each unit load that has a mode
    """
    warnings: Warnings = []
    for number, link in enumerate(problem.links):
        wanted = [DIRECTIONS.index(way) for at, way in attachments if at == link.name]
        if not wanted or (rows := _other_rows(problem, link)) is None:
            continue
        own = u[DOFS * (problem.mesh.n_node + number) + np.arange(DOFS)]
        section = _motion(problem, link, rows, u)
        moved, right = ((own / values * part).sum(axis=1)[wanted] for part in (own, section))
        ratio = moved / np.where(right > 0.0, right, np.inf) - 1.0
        worst = int(np.argmax(ratio))
        if ratio[worst] > DISTORTED:
            way = DIRECTIONS[wanted[worst]]
            warnings += _told(f"attachment {link.name} {way}", link, float(ratio[worst]), "link")
    return warnings


def _other_rows(problem: ShellProblem, link: Link) -> Array | None:
    """Motion of the point from those of the nodes by the other kind of link, (6, k, 6).

    None for a rigid link, and where a section link is not possible.
    """
    if link.kind == "section":
        points = problem.mesh.points_G[link.group.nodes]
        return averaged(points - link.point_G, link.group.weights)
    if link.kind != "average" or len(link.group.nodes) < 3:
        return None
    try:
        return section_rows(problem.mesh, problem.regions, link.group, link.point_G, link.name)
    except ShellError:
        return None


def _motion(problem: ShellProblem, link: Link, rows: Array, u: Array) -> Array:
    """Motion of the point, (6, m)."""
    nodes = u[: DOFS * problem.mesh.n_node].reshape(problem.mesh.n_node, DOFS, u.shape[1])
    return np.asarray(np.einsum("ikj,kjm->im", rows, nodes[link.group.nodes]))


def _told(state: str, link: Link, ratio: float, key: str) -> Warnings:
    return coded(
        "link-distorts-section",
        f'{state}: {key} = "{link.kind}" of {link.name} distorts the open end of the section: '
        f"its point moves {100.0 * ratio:.0f} % farther along its load than the section does; use "
        f'{key} = "{OTHER[link.kind]}" for {link.name}',
    )
