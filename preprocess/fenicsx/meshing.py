"""Meshes: from plain arrays to DOLFINx."""

import inspect
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .plain import IntArray, PlainMesh
from .stack import MPI, basix_ufl, dolfinx, gmsh_bridge, quiet, ufl


@dataclass(frozen=True)
class LabelledMesh:
    """A DOLFINx mesh with the region (physical group of gmsh) of each cell."""

    mesh: Any
    cell_labels: NDArray[np.int32]  # (n_cell,), in DOLFINx's cell order
    names: dict[str, int]  # region -> label

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return int(self.cell_labels.size)


def labelled_mesh(plain: PlainMesh) -> LabelledMesh:
    """Create a DOLFINx mesh on this process only; labels are rows of regions, from 1."""
    gdim = plain.points.shape[1]
    if basix_ufl is not None:
        domain = basix_ufl.element("Lagrange", plain.cell, plain.degree, shape=(gdim,))
    else:
        shape = ufl.Cell(plain.cell, geometric_dimension=gdim)
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", shape, plain.degree))
    create = dolfinx.mesh.create_mesh
    keyword = "e" if "e" in inspect.signature(create).parameters else "domain"
    with quiet():
        mesh = create(
            MPI.COMM_SELF, cells=_dolfinx_cells(plain), x=plain.points, **{keyword: domain}
        )
    labels = plain.region[np.asarray(mesh.topology.original_cell_index)] + 1
    return LabelledMesh(
        mesh, labels.astype(np.int32), {name: i for i, name in enumerate(plain.regions, start=1)}
    )


def _dolfinx_cells(plain: PlainMesh) -> IntArray:
    """The cells with their nodes in DOLFINx's order."""
    kind = getattr(dolfinx.mesh.CellType, plain.cell)
    order = gmsh_bridge.cell_perm_array(kind, plain.cells.shape[1])
    return np.ascontiguousarray(plain.cells[:, order])
