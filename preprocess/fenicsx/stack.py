"""Imports of DOLFINx, PETSc, SLEPc, gmsh and MPI.

This module handles all differences between versions of the FEniCSx stack. It tests for
features, not for version numbers, so that the rest of the preprocessor
is the same for DOLFINx 0.5 up to the present version. If the stack is incomplete,
importing this module raises `MissingFenicsx` (an ImportError), which states what
is missing and how to install it.
"""

import importlib.util
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from ..form_cache import use_own_folder

__all__ = [
    "HAS_MUMPS",
    "MPI",
    "Array",
    "MissingFenicsx",
    "PETSc",
    "SLEPc",
    "basix",
    "basix_ufl",
    "dolfinx",
    "gmsh",
    "gmsh_bridge",
    "quiet",
    "ufl",
    "versions",
]

Array = NDArray[np.float64]

HELP = (
    "Run `make fenicsx` to find or install FEniCSx, or install it yourself: on Debian and Ubuntu "
    "`apt-get install python3-dolfinx-real python3-slepc4py-real python3-gmsh python3-h5py "
    "python3-scipy`; with conda `fenics-dolfinx petsc=*=*real* slepc4py python-gmsh`."
)


class MissingFenicsx(ImportError):
    """A part of the FEniCSx stack is missing or cannot be used."""


try:
    from mpi4py import MPI  # must be first: the wheel of DOLFINx finds libmpi through it

    if importlib.util.find_spec("dolfinx_solver") is not None:
        importlib.import_module("dolfinx_solver")
    import petsc4py

    # Before PETSc is loaded, which otherwise waits for all ranks of the MPI job. Ranks of a pool
    # arrive here only when they get work. All objects are created with an explicit communicator.
    petsc4py.init(comm=MPI.COMM_SELF)

    use_own_folder()
    import basix
    import dolfinx
    import dolfinx.fem.petsc
    import gmsh
    import h5py
    import slepc4py
    import ufl
    from petsc4py import PETSc
    from slepc4py import SLEPc

    try:
        from dolfinx.io import gmsh as gmsh_bridge
    except ImportError:
        from dolfinx.io import gmshio as gmsh_bridge
    try:
        import basix.ufl as basix_ufl
    except ImportError:
        basix_ufl = None
except ImportError as _error:
    raise MissingFenicsx(f"{sys.executable} cannot use FEniCSx: {_error}. {HELP}") from _error

if np.dtype(PETSc.ScalarType).kind != "f":
    raise MissingFenicsx(
        f"{sys.executable} has a PETSc of complex numbers ({np.dtype(PETSc.ScalarType)}); "
        f"the real build is needed. {HELP}"
    )

_external = getattr(PETSc.Sys, "hasExternalPackage", lambda _name: False)
HAS_MUMPS = bool(_external("mumps"))


def versions() -> dict[str, str]:
    """Versions of all packages that may affect results, for the provenance of a file."""
    return {
        "dolfinx": dolfinx.__version__,
        "basix": basix.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        "slepc": ".".join(str(part) for part in SLEPc.Sys.getVersion()),
        "slepc4py": slepc4py.__version__,
        "gmsh": str(gmsh.__version__),
        "numpy": np.__version__,
        "h5py": h5py.__version__,
        "python": sys.version.split()[0],
        "factorisation": "mumps" if HAS_MUMPS else "petsc",
    }


@contextmanager
def quiet() -> Iterator[None]:
    """Remove the compiler calls of form compilation from the user's log."""
    previous = logging.root.manager.disable
    logging.disable(max(previous, logging.INFO))
    try:
        yield
    finally:
        logging.disable(previous)
