"""UFL forms assembled by DOLFINx, and meshes for them: a second formulation for tests."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx_spaces import (
    LabelledMesh,
    basix_ufl,
    cell_dofs,
    cell_name,
    function_space,
    labelled_mesh,
    quiet,
)

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.gmsh_model import plain_from_model
from plymotion.preprocess.fenicsx.stack import dolfinx


def mesh_from_geo(path: Path, parameters: dict[str, Any]) -> LabelledMesh:
    """Mesh a gmsh script with values for its parameters."""
    return labelled_mesh(fenicsx.run_script(path, parameters, gdim=2))


def mesh_from_model() -> LabelledMesh:
    """Convert the current plane gmsh model; every surface needs one physical group."""
    return labelled_mesh(plain_from_model("gmsh model", 2))


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


def compile_forms(forms: Sequence[Any]) -> list[Any]:
    """Compile UFL forms; the machine code is kept on disk and shared by later processes."""
    with quiet():
        return [dolfinx.fem.form(form) for form in forms]


def assembled(forms: Sequence[Any]) -> list[sp.csr_matrix]:
    """Assemble bilinear forms without boundary conditions."""
    return [_assemble(form) for form in compile_forms(forms)]


def _assemble(form: Any) -> sp.csr_matrix:
    matrix = dolfinx.fem.petsc.assemble_matrix(form)
    matrix.assemble()
    indptr, indices, data = matrix.getValuesCSR()
    shape = matrix.getSize()
    matrix.destroy()
    return sp.csr_matrix((data, indices, indptr), shape=shape)
