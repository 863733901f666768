"""Meshes and function spaces of DOLFINx on all supported versions.

Importing this module loads DOLFINx and UFL. The differences between versions of DOLFINx, UFL and
Basix, and the calls that end the process on wrong input, belong here.
"""

import inspect
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from .plain import PlainMesh
from .stack import MPI, dolfinx


def _first(*names: str) -> Any:
    """The first of these modules that this version has, or None."""
    for name in names:
        try:
            return import_module(name)
        except ImportError:
            continue
    return None


basix_ufl = _first("basix.ufl")  # elements without it are those of UFL
_gmsh_bridge = _first("dolfinx.io.gmsh", "dolfinx.io.gmshio")


@contextmanager
def quiet() -> Iterator[None]:
    """Remove the compiler calls of form compilation from the log."""
    previous = logging.root.manager.disable
    logging.disable(max(previous, logging.INFO))
    try:
        yield
    finally:
        logging.disable(previous)


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
    labels = plain.region[original_cells(mesh)] + 1
    return LabelledMesh(
        mesh, labels.astype(np.int32), {name: i for i, name in enumerate(plain.regions, start=1)}
    )


def _dolfinx_cells(plain: PlainMesh) -> IntArray:
    """The cells with their nodes in DOLFINx's order."""
    kind = getattr(dolfinx.mesh.CellType, plain.cell)
    order = _gmsh_bridge.cell_perm_array(kind, plain.cells.shape[1])
    return np.ascontiguousarray(plain.cells[:, order])


def original_cells(mesh: Any) -> IntArray:
    """Row of each cell in the input arrays of the mesh, (n_cell,)."""
    return np.array(mesh.topology.original_cell_index, dtype=np.int64)


def cell_name(mesh: Any) -> str:
    """Name of the cells, e.g. "quadrilateral"."""
    name = mesh.ufl_cell().cellname
    return str(name() if callable(name) else name)


def function_space(mesh: Any, element: Any) -> Any:
    """Function space of an element."""
    make = getattr(dolfinx.fem, "functionspace", None) or dolfinx.fem.FunctionSpace
    with quiet():
        return make(mesh, element)


def vector_space(mesh: Any, degree: int, size: int) -> Any:
    """Continuous Lagrange space of `size` components."""
    if basix_ufl is not None:
        element = basix_ufl.element("Lagrange", cell_name(mesh), degree, shape=(size,))
    else:
        element = ufl.VectorElement("Lagrange", mesh.ufl_cell(), degree, dim=size)
    return function_space(mesh, element)


def dof_coordinates(space: Any) -> Array:
    """Coordinates of the nodes of a space, (n_node, 3) [m]."""
    return np.array(space.tabulate_dof_coordinates())


def cell_dofs(space: Any) -> NDArray[np.int32]:
    """Nodes of each cell, (n_cell, nodes per cell), in DOLFINx's order."""
    table = space.dofmap.list
    if hasattr(table, "offsets"):  # AdjacencyList: all cells are of one kind
        table = np.asarray(table.array).reshape(len(table.offsets) - 1, -1)
    return np.array(table, dtype=np.int32)


def cell_function(mesh: Any, values: Any) -> Any:
    """A function with one constant value (or tensor) in each cell, values (n_cell, ...)."""
    table = np.asarray(values, dtype=float)
    shape, name = table.shape[1:], cell_name(mesh)
    if basix_ufl is not None:
        element = basix_ufl.element("DG", name, 0, shape=shape)
    else:
        family = "DQ" if name in ("quadrilateral", "hexahedron") else "DG"
        if shape:
            element = ufl.TensorElement(family, mesh.ufl_cell(), 0, shape=shape)
        else:
            element = ufl.FiniteElement(family, mesh.ufl_cell(), 0)
    found = dolfinx.fem.Function(function_space(mesh, element))
    rows = cell_dofs(found.function_space)[:, 0]
    array = found.x.array.reshape(rows.size, -1)
    array[rows] = table.reshape(rows.size, -1)
    return found
