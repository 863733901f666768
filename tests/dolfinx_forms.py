"""UFL forms assembled by DOLFINx, and meshes for them: a second formulation for tests."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import scipy.sparse as sp

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.spaces import LabelledMesh, labelled_mesh, quiet
from plymotion.preprocess.fenicsx.stack import dolfinx


def mesh_from_geo(path: Path, parameters: dict[str, Any]) -> LabelledMesh:
    """Mesh a gmsh script with values for its parameters."""
    return labelled_mesh(fenicsx.run_script(path, parameters, gdim=2))


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
