"""Mesh, plies and warping of a section in the form of the section file, in VTK's numbering."""

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.section.schema import SectionMeshData
from .. import fenicsx
from .layers import Layup
from .mesh import SectionMesh
from .space import SectionSpace

# Nodes of DOLFINx's cells in VTK's order, and VTK's number for the cell, by cell and degree.
VTK_CELLS = {
    ("triangle", 1): ((0, 1, 2), 5),
    ("triangle", 2): ((0, 1, 2, 5, 3, 4), 22),
    ("quadrilateral", 1): ((0, 1, 3, 2), 9),
    ("quadrilateral", 2): ((0, 1, 3, 2, 4, 6, 7, 5, 8), 28),
}


def mesh_data(mesh: SectionMesh, space: SectionSpace, lay: Layup) -> SectionMeshData:
    """The mesh with region, ply and directions of every cell."""
    nodes, cells, degree = fenicsx.geometry(mesh.labelled.mesh)
    order, vtk_type = VTK_CELLS[space.cell, degree]
    c, k = cells.shape
    names = tuple(mesh.labelled.names)
    row = {mesh.labelled.names[name]: i for i, name in enumerate(names)}
    # the integration point nearest to the centre represents the cell
    middle = np.argmin(
        np.linalg.norm(space.points - space.points.mean(axis=1, keepdims=True), axis=-1), axis=1
    )
    every = np.arange(c)
    A_BM = lay.A_BM[every, middle if lay.A_BM.shape[1] > 1 else 0]
    return SectionMeshData(
        nodes=nodes[:, :2].copy(),
        connectivity=cells[:, order].astype(np.int64).ravel(),
        offsets=np.arange(0, c * k + 1, k, dtype=np.int64),
        cell_types=np.full(c, vtk_type, dtype=np.int64),
        region=np.array([row[label] for label in mesh.labelled.cell_labels], dtype=np.int64),
        regions=names,
        ply=lay.ply[every, middle],
        layer_direction=lay.y2[every, middle],
        fibre=A_BM[:, :, 0],
    )


def nodal_displacements(space: SectionSpace, W: Array) -> Array:
    """Displacement columns (n_dof, m) at the nodes of the mesh, (m, n, 3)."""
    nodes, cells, degree = fenicsx.geometry(space.labelled.mesh)
    values, _ = fenicsx.basis(space.cell, space.degree, fenicsx.reference_nodes(space.cell, degree))
    m = W.shape[1]
    of_cells = values @ W.reshape(-1, 3 * m)[space.dofs]  # (c, k, 3 m)
    out = np.empty((len(nodes), 3, m))
    out[cells] = of_cells.reshape(*cells.shape, 3, m)
    return np.ascontiguousarray(np.moveaxis(out, 2, 0))
