"""Function spaces of DOLFINx."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .stack import Array, basix_ufl, dolfinx, quiet, ufl


def function_space(mesh: Any, element: Any) -> Any:
    """Function space of an element."""
    make = getattr(dolfinx.fem, "functionspace", None) or dolfinx.fem.FunctionSpace
    with quiet():
        return make(mesh, element)


def cell_name(mesh: Any) -> str:
    """Name of the cells, e.g. "quadrilateral"."""
    name = mesh.ufl_cell().cellname
    return str(name() if callable(name) else name)


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


def geometry(mesh: Any) -> tuple[Array, NDArray[np.int32], int]:
    """Nodes (n, 3) of a mesh [m], the nodes of its cells (n_cell, k), and their degree."""
    maps = getattr(mesh.geometry, "cmaps", None)
    tables = getattr(mesh.geometry, "dofmaps", None)
    cells = tables[0] if tables is not None else mesh.geometry.dofmap
    if hasattr(cells, "offsets"):
        cells = np.asarray(cells.array).reshape(len(cells.offsets) - 1, -1)
    degree = (maps[0] if maps is not None else mesh.geometry.cmap).degree
    return np.array(mesh.geometry.x), np.array(cells, dtype=np.int32), int(degree)


def original_cells(mesh: Any) -> NDArray[np.int64]:
    """Row of each cell in the input arrays of the mesh, (n_cell,)."""
    return np.array(mesh.topology.original_cell_index, dtype=np.int64)


def original_corners(mesh: Any) -> NDArray[np.int64]:
    """Rows of the nodes of each cell in the input arrays of the mesh, (n_cell, k).

    In the order of the dofs of a Lagrange space of the geometry's degree.
    """
    _, cells, _ = geometry(mesh)
    return np.array(mesh.geometry.input_global_indices, dtype=np.int64)[cells]
