"""The only package that imports DOLFINx, PETSc, SLEPc, gmsh and MPI.

If the stack is incomplete, importing it raises `MissingFenicsx`, an ImportError
that states what is missing and how to install it.
"""

from .cholesky import Cholesky, FactorisationError, SingularError, cholesky
from .eigen import EigenError, eigenpairs
from .gmsh_model import MeshError, plain_from_model
from .gmsh_script import gmsh_session, open_mesh, run_script
from .inertia import InertiaError, negative_pivots
from .meshing import LabelledMesh, labelled_mesh
from .plain import EDGES, NODES, NamedNodes, PlainMesh, used_nodes, with_centre_nodes
from .spaces import (
    cell_dofs,
    cell_name,
    dof_coordinates,
    geometry,
    original_cells,
    original_corners,
    quadrature,
    reference_nodes,
    vector_space,
)
from .stack import HAS_MUMPS, MPI, MissingFenicsx, gmsh, ufl, versions
from .team import ALONE, Team, world

__all__ = [
    "ALONE",
    "EDGES",
    "HAS_MUMPS",
    "MPI",
    "NODES",
    "Cholesky",
    "EigenError",
    "FactorisationError",
    "InertiaError",
    "LabelledMesh",
    "MeshError",
    "MissingFenicsx",
    "NamedNodes",
    "PlainMesh",
    "SingularError",
    "Team",
    "cell_dofs",
    "cell_name",
    "cholesky",
    "dof_coordinates",
    "eigenpairs",
    "geometry",
    "gmsh",
    "gmsh_session",
    "labelled_mesh",
    "negative_pivots",
    "open_mesh",
    "original_cells",
    "original_corners",
    "plain_from_model",
    "quadrature",
    "reference_nodes",
    "run_script",
    "ufl",
    "used_nodes",
    "vector_space",
    "versions",
    "with_centre_nodes",
    "world",
]
