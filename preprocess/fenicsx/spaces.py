"""Meshes and function spaces of DOLFINx on all supported versions.

Importing this module loads DOLFINx and UFL. The differences between versions of DOLFINx, UFL and
Basix, and the calls that end the process on wrong input, belong here.
"""

import inspect
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from cffi import VerificationError
from numpy.typing import NDArray

from ...solver.math.arrays import Array, IntArray
from .libraries import MPI, dolfinx, refused
from .plain_mesh import PlainMesh

try:
    basix_ufl: Any = import_module("basix.ufl")
except ImportError:
    basix_ufl = None  # elements are those of UFL
_parameters = inspect.signature(dolfinx.fem.Expression).parameters
JIT_OPTIONS = "jit_options" if "jit_options" in _parameters else "jit_params"
# Of all that is compiled; seconds to wait for a module that another process compiles.
JIT = {"timeout": 600}


@contextmanager
def quiet() -> Iterator[None]:
    """Compile without the calls of the compiler in the log; raises MissingFenicsx without one."""
    previous = logging.root.manager.disable
    logging.disable(max(previous, logging.INFO))
    try:
        yield
    except VerificationError as error:
        raise refused(f"DOLFINx needs a C compiler and Python's headers: {error}") from error
    finally:
        logging.disable(previous)


def element_of(
    cell: str, degree: int, shape: tuple[int, ...], gdim: int, *, dg: bool = False
) -> Any:
    """Lagrange element of scalars, vectors or tensors.

    Parameters
    ----------
    cell : its kind, such as "triangle"
    degree : of the functions
    shape : () of scalars
    gdim : coordinates of a point
    dg : discontinuous, of degree 0
    """
    if basix_ufl is not None:
        return basix_ufl.element("DG" if dg else "Lagrange", cell, degree, shape=shape)
    on = ufl.Cell(cell, geometric_dimension=gdim)
    family = "Lagrange"
    if dg:
        family = "DQ" if cell in ("quadrilateral", "hexahedron") else "DG"
    if not shape:
        return ufl.FiniteElement(family, on, degree)
    if len(shape) == 1:
        return ufl.VectorElement(family, on, degree, dim=shape[0])
    return ufl.TensorElement(family, on, degree, shape=shape)


def _element_of_rule(cell: str, degree: int, shape: tuple[int, ...], gdim: int) -> Any:
    """Element of tensors at the points of the integration rule of a degree."""
    if basix_ufl is not None:
        return basix_ufl.quadrature_element(cell, shape, degree=degree)
    on = ufl.Cell(cell, geometric_dimension=gdim)
    return ufl.TensorElement("Quadrature", on, degree, shape=shape, quad_scheme="default")


def dolfinx_mesh(plain: PlainMesh) -> Any:
    """Create a DOLFINx mesh on this process only."""
    gdim = plain.points.shape[1]
    domain = element_of(plain.cell, plain.degree, (gdim,), gdim)
    if basix_ufl is None:
        domain = ufl.Mesh(domain)
    create = dolfinx.mesh.create_mesh
    keyword = "e" if "e" in inspect.signature(create).parameters else "domain"
    kind = getattr(dolfinx.mesh.CellType, plain.cell)
    order = dolfinx.cpp.io.perm_gmsh(kind, plain.cells.shape[1])
    cells = np.ascontiguousarray(plain.cells[:, order])
    with quiet():
        return create(MPI.COMM_SELF, cells=cells, x=plain.points, **{keyword: domain})


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
    """Continuous Lagrange space of vectors.

    Parameters
    ----------
    mesh : of DOLFINx
    degree : of the functions
    size : components of a vector
    """
    return function_space(mesh, element_of(cell_name(mesh), degree, (size,), mesh.geometry.dim))


def dof_coordinates(space: Any) -> Array:
    """Coordinates of the nodes of a space, (n_node, 3) [m]."""
    return np.array(space.tabulate_dof_coordinates())


def cell_dofs(space: Any) -> NDArray[np.int32]:
    """Nodes of each cell, (n_cell, nodes per cell), in DOLFINx's order."""
    return _table(space.dofmap.list)


def nodes_of_cells(mesh: Any) -> IntArray:
    """Points that the mesh was made of, (n_cell, nodes per cell), in DOLFINx's order."""
    geometry = mesh.geometry
    table = getattr(geometry, "dofmaps", None)  # of each kind of cell, in newer versions
    if table is None:
        table = [geometry.dofmap]
    table = table(0) if callable(table) else table[0]
    return np.asarray(geometry.input_global_indices)[_table(table)]


def _table(rows: Any) -> NDArray[np.int32]:
    if hasattr(rows, "offsets"):  # AdjacencyList: all cells are of one kind
        rows = np.asarray(rows.array).reshape(len(rows.offsets) - 1, -1)
    return np.array(rows, dtype=np.int32)


def cell_function(mesh: Any, values: Any, rule: int | None = None) -> Any:
    """A function with constant values in each cell, or values at its points of integration.

    Parameters
    ----------
    mesh : of DOLFINx
    values : (n_cell, ...) of each cell, or (n_cell, q, ...) with a `rule`
    rule : degree of the rule of integration, which has q points; None: constant in each cell
    """
    table = np.asarray(values, dtype=float)
    cell, gdim = cell_name(mesh), mesh.geometry.dim
    if rule is None:
        element = element_of(cell, 0, table.shape[1:], gdim, dg=True)
    else:
        element = _element_of_rule(cell, rule, table.shape[2:], gdim)
    function = dolfinx.fem.Function(function_space(mesh, element))
    rows = cell_dofs(function.function_space).ravel()
    array = function.x.array.reshape(rows.size, -1)
    array[rows] = table.reshape(rows.size, -1)
    return function


def compiled_form(form: Any) -> Any:
    """Compile a UFL form; the machine code is kept on disk and shared by later processes."""
    with quiet():
        return dolfinx.fem.form(form, **{JIT_OPTIONS: JIT})


def assembled(form: Any) -> sp.csr_matrix:
    """Assemble a bilinear form without boundary conditions, in the order of DOLFINx."""
    matrix = dolfinx.fem.petsc.assemble_matrix(compiled_form(form))
    matrix.assemble()
    indptr, indices, data = matrix.getValuesCSR()
    shape = matrix.getSize()
    matrix.destroy()
    return sp.csr_matrix((data, indices, indptr), shape=shape)


def p2_cr_element(mesh: Any) -> Any:
    """Two vectors in space: continuous quadratic, and of Crouzeix and Raviart."""
    cell = cell_name(mesh)
    quadratic = element_of(cell, 2, (3,), 3)
    if basix_ufl is not None:
        return basix_ufl.mixed_element([quadratic, basix_ufl.element("CR", cell, 1, shape=(3,))])
    return ufl.MixedElement(quadratic, ufl.VectorElement("CR", mesh.ufl_cell(), 1, dim=3))
