"""What is installed: the imports of DOLFINx, PETSc, SLEPc, gmsh and MPI.

Everything version-dependent of the FEniCSx stack is met here, by looking for
the feature and never at a version number, so that the rest of the preprocessor
is one code for DOLFINx 0.5 up to the present one. Importing this module where
the stack is incomplete raises `MissingFenicsx` (an ImportError) that says what
is missing and how to get it.
"""

import importlib.util
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

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
    from mpi4py import MPI  # first: the wheel of DOLFINx finds libmpi through it

    if importlib.util.find_spec("dolfinx_solver") is not None:
        importlib.import_module("dolfinx_solver")
    import petsc4py

    # Before PETSc is loaded, which otherwise waits for all ranks of the MPI job: those of a pool
    # come here when they get work, or never. Every object here is told its communicator.
    petsc4py.init(comm=MPI.COMM_SELF)

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
    """Versions of everything that a number may depend on, for the provenance of a file."""
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
    """Keep the compiler calls of form compilation out of the user's log."""
    previous = logging.root.manager.disable
    logging.disable(max(previous, logging.INFO))
    try:
        yield
    finally:
        logging.disable(previous)
