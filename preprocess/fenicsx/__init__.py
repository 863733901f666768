"""The only door to DOLFINx, PETSc, SLEPc, gmsh and MPI.

Importing it where the stack is incomplete raises `MissingFenicsx`, an ImportError
that says what is missing and how to get it.
"""

from .cholesky import Cholesky, FactorisationError, cholesky
from .eigen import EigenError, eigenpairs
from .meshing import LabelledMesh, MeshError, gmsh_session, mesh_from_geo, mesh_from_model
from .spaces import (
    assemble,
    cell_dofs,
    cell_name,
    cell_space,
    compile_forms,
    dof_coordinates,
    function,
    set_cell_values,
    vector_space,
)
from .stack import HAS_MUMPS, MPI, MissingFenicsx, gmsh, ufl, versions

__all__ = [
    "HAS_MUMPS",
    "MPI",
    "Cholesky",
    "EigenError",
    "FactorisationError",
    "LabelledMesh",
    "MeshError",
    "MissingFenicsx",
    "assemble",
    "cell_dofs",
    "cell_name",
    "cell_space",
    "cholesky",
    "compile_forms",
    "dof_coordinates",
    "eigenpairs",
    "function",
    "gmsh",
    "gmsh_session",
    "mesh_from_geo",
    "mesh_from_model",
    "set_cell_values",
    "ufl",
    "vector_space",
    "versions",
]
