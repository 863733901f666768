"""Loads of a link that distort an open thin-walled end instead of moving its section.

The forces of an average link have a part normal to the walls, those of a section link are the
stresses far from the end of a member that twists evenly. Where they do not suit the section, they
deform the walls near the end. With the nodal forces F of the link and G of the other kind, both of
unit resultants, the point moves by F'u, of which F'K^-1 G is free of the local deformation of both
(Saint-Venant: F - G has no resultant). G'u is therefore the motion of the section, and
f.(F'u - G'u) the work of the load f on its distortion (docs/shells.md).
"""

from collections.abc import Sequence

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.specification import DIRECTIONS
from ..errors import ShellError
from .assembly import DOFS
from .links import Link, averaged
from .problem import ShellProblem
from .section_link import section_rows

DISTORTED = 0.1  # motion of the point beyond that of the section, over the latter
OF_ALL = 0.01  # least share of the strain energy of the shell
OTHER = {"average": "section", "section": "average"}

Warnings = list[dict[str, str]]


def link_warnings(
    problem: ShellProblem, u: Array, forces: Array, energy: Array, names: Sequence[str]
) -> Warnings:
    """Warnings about links whose loads distort the end that they act on.

    Parameters
    ----------
    u, forces : (n_dof, m) displacements and loads of load cases
    energy : (m,) their strain energy
    """
    found: Warnings = []
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
            found.append(_told(f"load case {names[worst]}", link, float(ratio[worst]), "kind"))
    return found


def interface_warnings(
    problem: ShellProblem, u: Array, values: Array, attachments: Sequence[tuple[str, str]]
) -> Warnings:
    """The same of the attachment modes of a body.

    Parameters
    ----------
    u, values : (n_dof, m) modes of unit modal mass, squared circular frequencies (m,)
    attachments : interface and direction of each unit load that has a mode
    """
    found: Warnings = []
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
            found.append(_told(f"attachment {link.name} {way}", link, float(ratio[worst]), "link"))
    return found


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


def _told(state: str, link: Link, ratio: float, key: str) -> dict[str, str]:
    other = OTHER[link.kind]
    text = (
        f'{state}: {key} = "{link.kind}" of {link.name} distorts the open end of the section: '
        f"its point moves {100.0 * ratio:.0f} % farther along its load than the section does; use "
        f'{key} = "{other}" for {link.name}'
    )
    return {"code": "link-distorts-section", "message": text}
