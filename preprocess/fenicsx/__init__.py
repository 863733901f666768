"""The only package that imports DOLFINx, PETSc, SLEPc, Basix, gmsh and MPI.

gmsh makes the meshes, Basix gives points of integration and nodes of reference cells, PETSc
factorises, SLEPc solves eigenproblems, MPI shares the work of several processes. DOLFINx compiles
what sections, shells and solids state in UFL and assembles it (assembly.py) or has it evaluated at
points (kernels.py).

If a part of the stack is missing, importing this package raises `MissingFenicsx`, an ImportError
that states what is missing and how to install it. Each name below loads its part of the stack
when it is asked for; __init__.pyi tells their types.
"""

from ...solver.math.catalogue import lazy_names
from . import libraries as _libraries  # raises MissingFenicsx

# Module of this folder -> the names that it offers; no module has the name of a function.
_PUBLIC = {
    "plain_mesh": (
        *("EDGES", "NODES", "NamedNodes", "PlainMesh", "used_nodes", "with_centre_nodes"),
        *("lagrange", "order_of_nodes", "quadrature", "reference_nodes"),
    ),
    "team": ("ALONE", "Team"),
    "eigen": ("eigenpairs",),
    "factorisation": ("Cholesky", "cholesky", "negative_pivots"),
    "multigrid": ("TwoGrids",),
    "gmsh_surface": (
        *("check_count", "check_size", "gmsh_session", "open_mesh", "plain_from_model"),
        *("run_script", "surface_mesh"),
    ),
    "kernels": (
        *("Kernel", "Rows", "Symbols", "compiled", "evaluated", "kernel", "matrices", "rows"),
        "symbols",
    ),
    "libraries": (
        *("EigenError", "FactorisationError", "InertiaError", "MeshError", "SingularError"),
        *("HAS_MUMPS", "MPI", "MissingFenicsx", "gmsh", "versions"),
    ),
    "assembly": ("Surface", "SurfacePattern"),
}

__getattr__, __dir__ = lazy_names(_PUBLIC, globals())
