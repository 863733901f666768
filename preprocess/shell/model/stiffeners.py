"""Stiffeners: beams along edges of the mesh, with the nodes of the shell.

A stiffener follows a physical curve. Section axes of each edge: x1 along the curve in the
direction that gmsh gives it, x3 the shell's normal there (mean of the cells at the edge), or x2 a
given direction made normal to x1; x2 = x3 x x1. Its reference line has the distance
`offset` from the edge along x2 and x3 and is rigidly connected to the nodes: u_ref = u + theta x o.

The elements are those of beam bodies, exact under end forces for any 6x6 stiffness.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ....solver.errors import check_known, few
from ....solver.math.arrays import REGULAR, Array, IntArray, smallest_eigenvalue
from ....solver.package.common.plain_data import canonical
from ...beam.line import BeamLine, LineSection
from ..elements.pairs import Choice, stiffness_kernel
from ..elements.single_cells import cell_matrices, cell_table
from ..groups import vector
from ..shell_cells import DOFS, ShellError, ShellMesh
from .links import carried
from .regions import Region, cell_axes

KEYS = ("at", "section", "stiffness", "mass", "x2_axis", "offset")
KINK = 0.9  # cosine between normals of neighbouring cells below which there is a fold
PARALLEL = 1e-6  # sine of the angle between x2_axis and the curve


@dataclass(frozen=True)
class Stiffener:
    """A beam of `l` elements on edges of a mesh of `n` nodes.

    Attributes
    ----------
    ends : (l, 2) nodes
    points_G : (n, 3) nodes of the mesh [m]
    A_GE : (l, 3, 3) section axes in G, v_G = A_GE v_E
    K, M : (6, 6) stiffness and mass per length of the section, section axes, order of the
        cross-sections [N, N m, N m2; kg/m, kg, kg m]
    offset : (2,) of the section's reference point along x2 and x3 [m]
    """

    name: str
    ends: IntArray
    points_G: Array
    A_GE: Array
    K: Array
    M: Array
    offset: Array

    @property
    def length(self) -> Array:
        """Lengths of the edges, (l,) [m]."""
        return self.line.lengths

    @property
    def _arms_G(self) -> Array:
        return np.asarray(self.A_GE[:, :, 1:] @ self.offset)

    @cached_property
    def line(self) -> BeamLine:
        """The elements of the reference line, each with ends of its own, in G."""
        nodes = (self.points_G[self.ends] + self._arms_G[:, None]).reshape(-1, 3)
        first = np.zeros(len(self.ends), dtype=np.int64)
        return BeamLine(nodes, self.A_GE, (LineSection(self.K, self.M),), first, step=2)

    @cached_property
    def carried(self) -> sp.csr_matrix:
        """Motion of these ends from that of the nodes of the mesh, (12 l, 6 n)."""
        blocks = np.repeat(carried(self._arms_G), 2, axis=0)
        entries = blocks, self.ends.ravel(), np.arange(len(blocks) + 1)
        return sp.bsr_matrix(entries, shape=(DOFS * len(blocks), self.points_G.size * 2)).tocsr()

    def stiffness(self) -> sp.csr_matrix:
        """Stiffness in G, (6 n, 6 n). Paper: Eq. (35)."""
        return self._of_nodes(self.line.stiffness())

    def mass(self, form: str) -> sp.csr_matrix:
        """Mass in G, "consistent" or "lumped", (6 n, 6 n)."""
        return self._of_nodes(self.line.mass_matrix(form))

    def geometric(self, u: Array) -> sp.csr_matrix:
        """Geometric stiffness (6 n, 6 n) in G of the axial forces of displacements u (n_dof,).

        That of a string along the reference line of the section: the work of the force N on the
        rotation of each element.
        """
        work = (self.axial_force @ u[: self.carried.shape[1]]) * self.length
        return self.chord_rotation.T @ sp.diags(np.repeat(work, 3)) @ self.chord_rotation

    @cached_property
    def axial_force(self) -> sp.csr_matrix:
        """Axial force of each element from the motion of the nodes, (l, 6 n) [N/m, N]."""
        count = len(self.ends)
        entries = self.A_GE[:, None, :, 0], 4 * np.arange(count) + 2, np.arange(count + 1)
        x1 = sp.bsr_matrix(entries, shape=(count, 12 * count))
        return sp.csr_matrix(x1 @ self.line.stiffness() @ self.carried)

    @cached_property
    def chord_rotation(self) -> sp.csr_matrix:
        """Slope of the reference line across x1 from the motion of the nodes, (3 l, 6 n) in G."""
        x1 = self.A_GE[:, :, 0]
        across = (np.eye(3) - x1[:, :, None] * x1[:, None, :]) / self.length[:, None, None]
        count = len(x1)
        blocks = np.stack([-across, across], axis=1).reshape(-1, 3, 3)
        entries = blocks, 2 * np.arange(2 * count), 2 * np.arange(count + 1)
        change = sp.bsr_matrix(entries, shape=(3 * count, 12 * count))
        return sp.csr_matrix(change @ self.carried)

    def _of_nodes(self, A: sp.csr_matrix) -> sp.csr_matrix:
        out = self.carried.T @ A @ self.carried
        return sp.csr_matrix(0.5 * (out + out.T))


class CellsBeside:
    """Cells at stiffeners: about their normals they do not turn with the nodes.

    A stiffener turns with its nodes. In a shear strain of the cells, the edge, which a section
    follows that is stiff in the plane, has another rotation about the normal than the cells have.
    With one rotation for both, the stiffener would keep shear strain away from the cells. A corner
    at a stiffener therefore has the mean rotation (v,x - u,y)/2, by area, of the cells around its
    node, up to stiffeners, folds and edges of several walls.

    Attributes
    ----------
    regions : the cells of this process
    rows : (m,) of those at stiffeners in each region
    change : (6 k m, n_dof) motion of their corners less that of the nodes, for each region
    """

    def __init__(
        self,
        mesh: ShellMesh,
        regions: Sequence[Region],
        own: Sequence[Region],
        ends: IntArray,
        n_dof: int,
    ) -> None:
        """`regions` has all cells, `own` those of this process; `ends` (l, 2) of all stiffeners."""
        at = np.zeros(mesh.n_node, dtype=bool)
        at[ends] = True
        corners, excess = zip(
            *(_corners(mesh, region, at, n_dof) for region in regions), strict=True
        )
        keys, area, normal = (np.concatenate(part) for part in zip(*corners, strict=True))
        order = np.argsort(keys)
        mean_excess = _means(mesh, keys, area, normal, ends) @ sp.vstack(excess)
        self.regions, self.rows, self.change = own, [], []
        for region in own:
            rows = np.flatnonzero(at[region.nodes].any(axis=1))
            row, corner = np.nonzero(at[region.nodes[rows]])
            key = region.cells[rows[row]] * mesh.n_node + region.nodes[rows[row], corner]
            sides = order[np.searchsorted(keys, key, sorter=order)]
            k, count = region.nodes.shape[1], np.arange(len(sides))
            place = (DOFS * (k * row + corner) + 3)[:, None] + np.arange(3)
            entries = -normal[sides].ravel(), (place.ravel(), np.repeat(count, 3))
            shape = (DOFS * k * len(rows), len(sides))
            self.rows.append(rows)
            self.change.append(sp.csr_matrix(entries, shape=shape) @ mean_excess[sides])

    def moved(self, number: int, corners: Array, u: Array) -> Array:
        """Add the change to motions of the corners of a region; return them.

        Parameters
        ----------
        number : of the region
        corners : (c, 6 k, m) motions; changed in place
        u : (n_dof, m) the states
        """
        change = self.change[number] @ u
        corners[self.rows[number]] += change.reshape(-1, *corners.shape[1:])
        return corners

    def stiffness(self, choice: Choice) -> sp.csr_matrix:
        """What the change adds to the stiffness of nodes, (n_dof, n_dof) [N/m, N, N m]."""
        parts = []
        for region, rows, change in zip(self.regions, self.rows, self.change, strict=True):
            k = region.nodes.shape[1]
            some, size = region.geometry[rows], DOFS * k
            table = cell_table(some, region.stiffness, choice)
            K = cell_matrices(some, stiffness_kernel(k, choice), table)
            own = np.arange(len(rows))
            C = sp.bsr_matrix((K, own, np.arange(len(rows) + 1)), shape=2 * (size * len(rows),))
            dofs = DOFS * region.nodes[rows][:, :, None] + np.arange(DOFS)
            entries = (np.ones(dofs.size), dofs.ravel(), np.arange(dofs.size + 1))
            moved = sp.csr_matrix(entries, shape=change.shape)
            across = moved.T @ (C @ change)
            parts.append(across + across.T + change.T @ (C @ change))
        return sp.csr_matrix(sum(parts[1:], parts[0]))


def _corners(
    mesh: ShellMesh, region: Region, at: Array, n_dof: int
) -> tuple[tuple[IntArray, Array, Array], sp.csr_matrix]:
    """Corners at nodes marked by `at`: key, area and normal of each, and rows of their excess.

    The excess is the rotation of the node about the normal less that of the cell.
    """
    rows, corner = np.nonzero(at[region.nodes])
    nodes, A = region.nodes[rows], region.geometry.A_GE[rows]
    node, e3 = nodes[np.arange(len(rows)), corner], A[:, :, 2]
    turn = _cell_rotation(region.geometry.corners_G[rows], A)
    values = np.concatenate([e3[:, None], -turn], axis=1)
    dofs = DOFS * np.concatenate([node[:, None], nodes], axis=1)
    dofs[:, 0] += 3
    columns = dofs[:, :, None] + np.arange(3)
    starts = columns[0].size * np.arange(len(rows) + 1) if len(rows) else np.zeros(1, int)
    excess = sp.csr_matrix((values.ravel(), columns.ravel(), starts), shape=(len(rows), n_dof))
    return (region.cells[rows] * mesh.n_node + node, region.geometry.area[rows], e3), excess


def _cell_rotation(corners_G: Array, A_GE: Array) -> Array:
    """Rotation (v,x - u,y)/2 of cells about e3 from displacements of their corners, (c, k, 3)."""
    xy = corners_G @ A_GE[:, :, :2]
    xy = xy - xy.mean(axis=1, keepdims=True)
    slopes = xy @ np.linalg.inv(np.swapaxes(xy, 1, 2) @ xy)  # of the best plane, (c, k, 2)
    e1, e2 = A_GE[:, None, :, 0], A_GE[:, None, :, 1]
    return 0.5 * (slopes[:, :, :1] * e2 - slopes[:, :, 1:] * e1)


def _means(
    mesh: ShellMesh, keys: IntArray, area: Array, normal: Array, ends: IntArray
) -> sp.csr_matrix:
    """Means of values about the normals over corners (c,) of a node, up to stiffeners and folds.

    Parameters
    ----------
    keys : cell and node of each corner, as cell n + node
    """
    edges, order = mesh.edges, np.argsort(keys)
    sides = edges.shared[~np.isin(np.flatnonzero(edges.count == 2), edges.find(ends))]
    pairs = edges.owner[sides, None] * mesh.n_node + edges.nodes[edges.number[sides[:, :1]]]
    pairs = np.moveaxis(pairs, 1, 2).reshape(-1, 2)  # corners of a node in two cells
    pairs_of_cells = order[np.searchsorted(keys, pairs, sorter=order).clip(max=len(keys) - 1)]
    pairs_of_cells = pairs_of_cells[(keys[pairs_of_cells] == pairs).all(axis=1)]
    cosine = np.einsum("pi,pi->p", *np.moveaxis(normal[pairs_of_cells], 1, 0))
    a, b = pairs_of_cells[np.abs(cosine) > KINK].T
    graph = sp.csr_matrix((np.ones(len(a)), (a, b)), shape=2 * (len(keys),))
    count, group = connected_components(graph, directed=False)
    first = np.unique(group, return_index=True)[1]
    sign = np.sign(np.einsum("ci,ci->c", normal, normal[first[group]]))
    weight = sign * area / np.bincount(group, weights=area)[group]
    corner = np.arange(len(keys))
    gathered = sp.csr_matrix((weight, (group, corner)), shape=(count, len(keys)))
    return sp.csr_matrix((sign, (corner, group)), shape=gathered.shape[::-1]) @ gathered


def read_stiffeners(
    table: Mapping[str, Any], mesh: ShellMesh, regions: Sequence[Region], where: str
) -> list[Stiffener]:
    """The stiffeners of a specification.

    Parameters
    ----------
    table : {name: {at, section or stiffness and mass, ...}}
    mesh : of the shell
    regions : all cells, whose normals give the axes
    where : key of the table, for messages

    Raises
    ------
    ShellError : no such curve, no section or a wrong one, an axis along the curve.
    SectionError, MaterialError : the description of the section is wrong.
    """
    stiffeners = []
    for name, entry in table.items():
        place = f"{where}.{name}"
        at = str(entry.get("at"))
        text = f"expected a physical curve of the mesh, it has {few(mesh.curves) or 'none'}"
        check_known(at, mesh.curves, f"{place}.at", ShellError, text)
        ends = np.asarray(mesh.curves[at])
        along = np.diff(mesh.points_G[ends], axis=1)[:, 0]
        x1 = along / np.linalg.norm(along, axis=1)[:, None]
        K, M = _section(entry, place)
        A_GE = _axes(entry.get("x2_axis"), x1, ends, mesh, regions, place)
        offset = np.asarray(entry.get("offset", (0.0, 0.0)), dtype=float)
        if offset.shape != (2,) or not np.isfinite(offset).all():
            raise ShellError(
                f"{place}.offset = {entry['offset']!r}: expected two lengths, along x2 and x3"
            )
        stiffeners.append(Stiffener(name, ends, mesh.points_G, A_GE, K, M, offset))
    return stiffeners


def _axes(
    given: Any, x1: Array, ends: IntArray, mesh: ShellMesh, regions: Sequence[Region], where: str
) -> Array:
    """Section axes of each edge, (l, 3, 3)."""
    if given is None:
        normals = cell_axes(mesh, regions)[mesh.edges.owner, :, 2]
        normal = np.concatenate([mesh.edges.sums(normals), np.zeros((1, 3))])[mesh.edges.find(ends)]
        x3 = np.cross(x1, np.cross(normal, x1))
        x2 = np.cross(x3 / np.linalg.norm(x3, axis=1)[:, None], x1)
    else:
        x2 = np.broadcast_to(vector(given, f"{where}.x2_axis"), x1.shape)
        x2 = x2 - np.einsum("li,li->l", x2, x1)[:, None] * x1
        size = np.linalg.norm(x2, axis=1)
        if not (size > PARALLEL * np.linalg.norm(given)).all():
            raise ShellError(f"{where}.x2_axis = {given!r}: expected a direction across the curve")
        x2 = x2 / size[:, None]
    return np.stack([x1, x2, np.cross(x1, x2)], axis=2)


def _section(entry: Mapping[str, Any], where: str) -> tuple[Array, Array]:
    """Stiffness and mass of the section, each (6, 6)."""
    if ("section" in entry) == ("stiffness" in entry) or ("stiffness" in entry) != (
        "mass" in entry
    ):
        raise ShellError(f"{where}: expected `section`, or `stiffness` with `mass`")
    if "section" in entry:
        section = _analysed(canonical(entry["section"]), f"{where}.section")
        return section.K, section.M
    matrices = []
    for key, least in (("stiffness", REGULAR), ("mass", -1e-12)):
        A = np.asarray(entry[key], dtype=float)
        if A.shape != (6, 6) or not np.allclose(A, A.T, rtol=1e-9, atol=1e-12 * np.abs(A).max()):
            raise ShellError(f"{where}.{key}: expected a symmetric matrix of 6 rows")
        if not smallest_eigenvalue(A) > least:
            kind = "definite" if key == "stiffness" else "semi-definite"
            raise ShellError(f"{where}.{key}: expected a positive {kind} matrix")
        matrices.append(A)
    return matrices[0], matrices[1]


@lru_cache(maxsize=64)
def _analysed(text: str, where: str) -> Any:
    """Analyse a section once and reuse the result for other stiffeners."""
    from ...section.section_analysis import analyse  # here: few shells have stiffeners

    return analyse(json.loads(text), where=where, estimate=False)
