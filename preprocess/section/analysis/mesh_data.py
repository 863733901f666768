"""Mesh, plies and warping of a section in the form of the section file, in VTK's numbering."""

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.section.schema import SectionMeshData
from ..mesh.cells import FULL, CellMesh, IntArray
from ..mesh.mesh import SectionMesh
from ..space.layers import Layup
from ..space.space import SectionSpace

# VTK's number for a cell with these of our nodes, by kind. A cell with others is written with all.
# Our order of corners, middles and centre is VTK's.
VTK_CELLS = ({3: 5, 6: 22}, {4: 9, 8: 23, 9: 28})


def mesh_data(mesh: SectionMesh, space: SectionSpace, lay: Layup) -> SectionMeshData:
    """The mesh with region, ply and directions of every cell."""
    cells = mesh.cells
    c = cells.n_cell
    points, tables, types = _numbered(cells)
    connectivity = [table[table >= 0] for table in tables]
    # the integration point nearest to the centre represents the cell
    areas = space.weights[..., None]
    centre = (areas * space.points).sum(axis=1, keepdims=True) / areas.sum(axis=1, keepdims=True)
    away = np.linalg.norm(space.points - centre, axis=-1)
    middle = np.argmin(np.where(space.weights > 0.0, away, np.inf), axis=1)
    every = np.arange(c)
    A_BM = lay.A_BM[every, middle if lay.A_BM.shape[1] > 1 else 0]
    return SectionMeshData(
        nodes=points,
        connectivity=np.concatenate(connectivity),
        offsets=np.cumsum([0, *map(len, connectivity)]).astype(np.int64),
        cell_types=types,
        region=cells.region.astype(np.int64),
        regions=cells.regions,
        ply=lay.ply[every, middle],
        layer_direction=lay.y2[every, middle],
        fibre=A_BM[:, :, 0],
    )


def nodal_displacements(space: SectionSpace, W: Array) -> Array:
    """Displacement columns (n_dof, m) at the nodes of `mesh_data`, (m, n, 3)."""
    points, tables, _ = _numbered(space.mesh)
    out = np.zeros((len(points), 3, W.shape[1]))
    for (kind, rows), values in zip(
        space.mesh.of_kinds, space.at_corners_and_middles(W), strict=True
    ):
        nodes = tables[rows, : FULL[kind]]
        out[nodes[nodes >= 0]] = values[nodes >= 0]
    return np.ascontiguousarray(np.moveaxis(out, 2, 0))


def _numbered(mesh: CellMesh) -> tuple[Array, IntArray, IntArray]:
    """Positions of the nodes in use, nodes of each cell (c, 9) with -1 for none, VTK's types."""
    used, compact = np.unique(mesh.nodes, return_inverse=True)
    absent = int(used[0] < 0)
    tables = compact.reshape(mesh.nodes.shape).astype(np.int64) - absent
    points = [mesh.points[used[absent:]]]
    types = np.zeros(mesh.n_cell, dtype=np.int64)
    total = len(points[0])
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        full = FULL[kind]
        there = tables[rows] >= 0
        count = there.sum(axis=1)
        types[rows] = VTK_CELLS[kind][full]
        regular = np.zeros(len(rows), dtype=bool)
        for n, vtk in VTK_CELLS[kind].items():
            these = (count == n) & there[:, :n].all(axis=1)
            types[rows[these]] = vtk
            regular |= these
        cell, node = np.nonzero((tables[rows][:, :full] < 0) & ~regular[:, None])
        tables[rows[cell], node] = total + np.arange(len(cell))
        points.append(shape[cell, node])
        total += len(cell)
    return np.concatenate(points), tables, types
