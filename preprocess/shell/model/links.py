"""Links: a reference point with six degrees of freedom that drives, or follows, a group of nodes.

    "rigid"    (RBE2) every node of the group follows the reference point as a rigid body:
               u_i = u_r + theta_r x d_i, theta_i = theta_r. The group cannot deform.
    "average"  (RBE3) the reference point follows the group: its motion is the best-fitting rigid
               motion of the group, by weighted least squares of displacements. A force or moment
               on it is distributed over the group with exactly its resultant.
    "section"  the same for the open end of a thin-walled section, whose loads act as the stresses
               of Saint-Venant.

If displacements do not determine a rotation (nodes on a line, or one node), the mean of the nodal
rotations about that axis is used.

A force or moment at the point of an average link is spread as a rigid distribution of forces
over the nodes. Its part normal to the walls distorts a section that has no diaphragm. The link of
kind "section" spreads the loads as the stresses far from the end, which are in the walls:

- extension and bending: axial flow n = E (a + b y + c z), E the axial stiffness of a wall without
  transverse stress;
- shear forces: shear flow q = G u,s in equilibrium with the change of n in bending,
  int q v,s ds = int E (y or z) v ds for every warping v;
- torsion: shear flow q = G (u,s + r x t . x) of a twist, int q v,s ds = 0 (Bredt's flow in every
  cell), and the twisting moments 4 D66 of the walls, which alone carry it in an open section.

These are six fields of nodal forces F0 (6 k, 6). With the rigid motions R of the nodes,
F = F0 (R' F0)^-1 has unit resultants, and the point moves by F' u: exact for rigid motions, and
the point's loads do the work of the nodal forces.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....solver.errors import check_known
from ....solver.math.arrays import Array, IntArray
from ....solver.package.specification import SHELL_LINK_KINDS
from ..groups import Group, united, vector
from ..shell_cells import DOFS, ShellError, ShellMesh
from .regions import Region

OPEN = 1e-8  # second moment about an axis over the largest: below it the rotation is undetermined


@dataclass(frozen=True)
class Link:
    """A reference point and its group of nodes."""

    name: str
    kind: str  # one of SHELL_LINK_KINDS
    group: Group
    point_G: Array  # (3,)                                  [m]
    rows: Array | None = None  # (6, k, 6) of a section link: motion from those of the nodes


def read_links(
    table: Mapping[str, Any], mesh: ShellMesh, regions: Sequence[Region], where: str
) -> list[Link]:
    """The links of a specification.

    Parameters
    ----------
    table : {name: {at, kind, point}}; `at` is a group or a list of them, the default of point
        [m] the centre of all
    mesh : of the shell
    regions : with their laminates, for section links
    where : key of the table, for messages

    Raises
    ------
    ShellError
        An unknown group or kind, a node in two rigid links; as `section_rows`.
    """
    links = []
    owner: dict[int, str] = {}
    for name, entry in table.items():
        place = f"{where}.{name}"
        kind = entry.get("kind")
        check_known(kind, SHELL_LINK_KINDS, f"{place}.kind", ShellError)
        of = united(mesh, entry.get("at", ""), f"{place}.at")
        point = entry.get("point")
        centre = of.centre_G if point is None else vector(point, f"{place}.point")
        rows = None
        if kind == "section":
            rows = section_rows(mesh, regions, of, centre, f"{place}.at")
        links.append(Link(name, kind, of, centre, rows))
        for node in of.nodes.tolist() if kind == "rigid" else ():
            if node in owner:
                raise ShellError(
                    f"{place}.at = {of.name!r}: shares a node with the rigid link "
                    f"{owner[node]!r}; a node follows one reference point only"
                )
            owner[node] = name
    return links


def cross_matrix(a: Array) -> Array:
    """Matrices a~ with a~ b = a x b, (..., 3, 3) of vectors (..., 3)."""
    return np.cross(np.eye(3), a[..., None, :])


def carried(arms_G: Array) -> Array:
    """Displacement and rotation of nodes that follow a point, (k, 6, 6): u = u_r + theta_r x d."""
    out = np.tile(np.eye(6), (len(arms_G), 1, 1))
    out[:, :3, 3:] = -cross_matrix(arms_G)
    return out


def averaged(arms_G: Array, weights: Array) -> Array:
    """Motion of the reference point from those of the nodes, (6, k, 6).

    Parameters
    ----------
    arms_G : (k, 3) from the reference point to the nodes [m]
    weights : (k,) above 0
    """
    share = weights / weights.sum()
    centre = share @ arms_G
    arms = arms_G - centre
    cross = cross_matrix(arms)
    inertia = np.einsum("k,kji,kjl->il", share, cross, cross)
    value, axis = np.linalg.eigh(inertia)
    length = np.linalg.norm(arms_G, axis=1).max(initial=0.0)
    open_ = value <= OPEN * max(value[-1], 1e-12 * length**2, 1e-300)
    known, left = axis[:, ~open_], axis[:, open_]
    inverse = known @ np.diag(1.0 / value[~open_]) @ known.T
    out = np.zeros((6, len(arms), 6))
    # angular momentum of the displacements over the second moment, then the mean of rotations
    out[3:, :, :3] = np.einsum("ij,kjl,k->ikl", inverse, cross, share)
    out[3:, :, 3:] = np.einsum("ij,k->ikj", left @ left.T, share)
    # the displacement of the centre, transferred to the reference point: - theta x centre
    out[:3, :, :3] = np.einsum("ij,k->ikj", np.eye(3), share)
    out[:3] += np.einsum("ij,jkl->ikl", cross_matrix(centre), out[3:])
    return out


FLAT = 1e-6  # distance of nodes from the plane of the section, and of a line, over its size
ACROSS = 0.5  # least sine between walls and the plane of the section
SINGULAR = 1e-9  # eigenvalue of R' F0 of unit diagonal, of a section without its six fields


def section_rows(
    mesh: ShellMesh, regions: Sequence[Region], of: Group, point_G: Array, where: str
) -> Array:
    """Motion of the reference point from those of the nodes of the group, (6, k, 6).

    Parameters
    ----------
    mesh : of the shell
    regions : with their laminates
    of : nodes of a curve in a plane
    point_G : (3,) reference point [m]
    where : key that names the group, for messages

    Raises
    ------
    ShellError : the group is no curve, the curve is not in a plane, or is a straight line.
    """
    if of.kind != "curve":
        raise ShellError(f"{where} = {of.name!r}: a {of.kind}; a section link needs a curve")
    if of.name not in mesh.curves:
        raise ShellError(f"{where} = {of.name!r}: a section link needs one curve")
    points = mesh.points_G[of.nodes]
    centred = points - points.mean(axis=0)
    _, size, axes = np.linalg.svd(centred, full_matrices=False)
    if size[2] > FLAT * size[0] or size[1] <= FLAT * size[0]:
        shape = "a straight line" if size[1] <= FLAT * size[0] else "not in a plane"
        raise ShellError(
            f"{where} = {of.name!r}: {shape}; a section link needs the edge of a thin-walled "
            'section; use kind = "average"'
        )
    x = axes[2]
    ends = np.searchsorted(of.nodes, mesh.curves[of.name])
    stiffness = _wall_stiffness(mesh, regions, mesh.curves[of.name], x, f"{where} = {of.name!r}")
    F0 = _fields(points, ends, stiffness, x)
    R = carried(points - point_G).reshape(DOFS * len(points), DOFS)
    resultants = R.T @ F0
    whole = resultants / np.abs(resultants).max(axis=0)
    if np.linalg.svd(whole / np.abs(whole).max(axis=1)[:, None], compute_uv=False)[-1] < SINGULAR:
        raise ShellError(f"{where} = {of.name!r}: the section does not carry all six resultants")
    F = np.linalg.solve(resultants.T, F0.T)
    return np.asarray(F.reshape(DOFS, len(points), DOFS))


def _wall_stiffness(
    mesh: ShellMesh, regions: Sequence[Region], lines: IntArray, x: Array, where: str
) -> Array:
    """E and G [N/m] and 4 D66 [N m] of each line, (s, 3), sums over its cells."""
    out, (lines_at, side) = np.zeros((len(lines), 3)), mesh.edges.on(lines)
    owner = mesh.edges.owner[side]
    if len(np.unique(lines_at)) < len(lines):
        raise ShellError(f"{where}: lines of the curve are no edges of cells")
    for region in regions:
        hit = np.isin(owner, region.cells)
        row, cells = lines_at[hit], np.searchsorted(region.cells, owner[hit])
        c, s = ((region.geometry.A_GE[cells, :, k] @ x) for k in (0, 1))
        length = np.hypot(c, s)
        if not (length > ACROSS).all():
            raise ShellError(
                f"{where}: cells lie in the plane of the curve; a section link needs walls across "
                "the plane of the section"
            )
        c, s = c / length, s / length
        # strain and curvature along x and its normal from those along e1, e2
        T = np.empty((len(cells), 3, 3))
        T[:, 0] = np.stack([c * c, s * s, c * s], axis=1)
        T[:, 1] = np.stack([s * s, c * c, -c * s], axis=1)
        T[:, 2] = np.stack([-2 * c * s, 2 * c * s, c * c - s * s], axis=1)
        flexible = T @ np.linalg.inv(region.stiffness.A) @ np.swapaxes(T, 1, 2)
        bending = T @ np.linalg.inv(region.stiffness.D) @ np.swapaxes(T, 1, 2)
        stiffness = np.stack(
            [1.0 / flexible[:, 0, 0], 1.0 / flexible[:, 2, 2], 4.0 / bending[:, 2, 2]], axis=1
        )
        np.add.at(out, row, stiffness)
    return out


def _fields(points: Array, ends: IntArray, stiffness: Array, x: Array) -> Array:
    """Nodal forces and moments of the six fields, (6 k, 6)."""
    k = len(points)
    i, j = ends.T
    along = points[j] - points[i]
    L = np.linalg.norm(along, axis=1)
    t = along / L[:, None]
    E, G, GJ = stiffness.T
    third = E * L / 6.0
    weight = np.zeros((k, k))  # int E N_i N_j ds
    for a, b, factor in ((i, i, 2.0), (j, j, 2.0), (i, j, 1.0), (j, i, 1.0)):
        np.add.at(weight, (a, b), factor * third)
    centre = weight.sum(axis=0) @ points / weight.sum()
    arms = points - centre
    first = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
    first /= np.linalg.norm(first)
    y, z = arms @ first, arms @ np.cross(x, first)
    forces = np.zeros((k, DOFS, 6))
    axial = weight @ np.stack([np.ones(k), y, z], axis=1)
    forces[:, :3, :3] = x[:, None] * axial[:, None]
    laplacian = np.zeros((k, k))  # int G N_i,s N_j,s ds
    for a, b, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
        np.add.at(laplacian, (a, b), sign * G / L)
    middle = 0.5 * (arms[i] + arms[j])
    swept = np.cross(middle, t) @ x  # r x t . x
    twist = np.zeros(k)
    np.add.at(twist, j, -G * swept)
    np.add.at(twist, i, G * swept)
    loads = np.stack([twist, axial[:, 1], axial[:, 2]], axis=1)
    warping = np.linalg.lstsq(laplacian, loads, rcond=None)[0]
    flow = G[:, None] * (warping[j] - warping[i]) / L[:, None]
    flow[:, 0] += G * swept
    half = 0.5 * (flow * L[:, None])[:, None, :] * t[:, :, None]  # (s, 3, 3)
    for end in (i, j):
        np.add.at(forces[:, :3, 3:], end, half)
        np.add.at(forces[:, 3:, 3], end, 0.5 * (GJ * L)[:, None] * x)
    return forces.reshape(DOFS * k, 6)
