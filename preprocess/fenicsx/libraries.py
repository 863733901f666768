"""DOLFINx, PETSc, SLEPc, gmsh and MPI, each loaded when it is first asked for; error classes.

This module handles all differences between versions of the FEniCSx stack. It tests for
features, not for version numbers, so that the rest of the preprocessor
is the same for DOLFINx 0.5 up to the present version. If the stack is incomplete,
importing this module raises `MissingFenicsx` (an ImportError), which states what
is missing and how to install it. So does a part that is there but does not load.

Most analyses need a few of the parts only: loading all of them takes 0.6 s of processor time,
DOLFINx with UFL half of it."""

import ctypes
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from ...solver.errors import HOW_TO_INSTALL_FENICSX as HELP
from ..form_cache import use_own_folder


class MeshError(Exception):
    """A gmsh model cannot be used as a finite-element mesh."""


class FactorisationError(Exception):
    """A matrix is not symmetric positive definite."""


class SingularError(FactorisationError):
    """The solution of a random load is so large that the matrix appears to be singular."""


class InertiaError(Exception):
    """The signs of the eigenvalues cannot be counted: the matrix is singular to round-off."""


class EigenError(Exception):
    """Fewer eigenpairs than requested, or eigenpairs that do not satisfy their equation."""


Array = NDArray[np.float64]

MODULES = ("mpi4py", "petsc4py", "slepc4py", "basix", "dolfinx", "ufl", "gmsh")


class MissingFenicsx(ImportError):
    """A part of the FEniCSx stack is missing or cannot be used."""


def refused(reason: object) -> MissingFenicsx:
    """The error that states why FEniCSx cannot be used, and the remedy."""
    return MissingFenicsx(f"{sys.executable} cannot use FEniCSx: {reason}. {HELP}")


for _name in MODULES:
    if find_spec(_name) is None:
        raise refused(f"No module named {_name!r}")


# The largest values that glibc's malloc gives these limits by itself, see mallopt(3).
MMAP_THRESHOLD, TRIM_THRESHOLD = (-3, 32 * 2**20), (-1, 64 * 2**20)  # names in malloc.h, bytes


def keep_memory() -> None:
    """Let glibc keep freed memory for the next arrays.

    With the libraries of DOLFINx's wheel, arrays of a few megabytes went back to the system at
    once: fetching them again was a quarter of the time for a section of 6000 unknowns. With those
    of Debian they stay anyway.
    """
    if mallopt := getattr(ctypes.CDLL(None), "mallopt", None):
        for limit in (MMAP_THRESHOLD, TRIM_THRESHOLD):
            mallopt(*limit)


def _mpi() -> Any:
    MPI = import_module("mpi4py.MPI")
    if find_spec("dolfinx_solver") is not None:  # the wheel of DOLFINx
        keep_memory()
        import_module("dolfinx_solver")
    return MPI


def _after_mpi(name: str) -> Any:
    _part("MPI")  # the wheel of DOLFINx finds libmpi through it
    return import_module(name)


def _petsc() -> Any:
    # Before PETSc is loaded, which otherwise waits for all ranks of the MPI job. Ranks of a pool
    # arrive here only when they get work. All objects are created with an explicit communicator.
    # PETSc would read .petscrc of the current folder, which can name a library to load.
    import_module("petsc4py").init(["", "-skip_petscrc"], comm=_part("MPI").COMM_SELF)
    PETSc = import_module("petsc4py.PETSc")
    if np.dtype(PETSc.ScalarType).kind != "f":
        raise MissingFenicsx(
            f"{sys.executable} has a PETSc of complex numbers ({np.dtype(PETSc.ScalarType)}); "
            f"the real build is needed. {HELP}"
        )
    return PETSc


def _has_mumps() -> bool:
    external = getattr(_part("PETSc").Sys, "hasExternalPackage", lambda _name: False)
    return bool(external("mumps"))


def _slepc() -> Any:
    _part("PETSc")
    return import_module("slepc4py.SLEPc")


def _dolfinx() -> Any:
    # After those of MPI and DOLFINx the libraries of gmsh take 0.15 and 0.35 s to load, else 0.1 s.
    import_module("gmsh")
    _part("PETSc")
    use_own_folder()
    import_module("dolfinx.fem.petsc")
    return import_module("dolfinx")


_PARTS: dict[str, Callable[[], Any]] = {
    "HAS_MUMPS": _has_mumps,
    "MPI": _mpi,
    "PETSc": _petsc,
    "SLEPc": _slepc,
    "basix": lambda: _after_mpi("basix"),
    "dolfinx": _dolfinx,
    "gmsh": lambda: import_module("gmsh"),
}


def _part(name: str) -> Any:
    """A part of the stack, loaded unless it is there."""
    if name in globals():
        return globals()[name]
    try:
        part = _PARTS[name]()
    except MissingFenicsx:
        raise
    except ImportError as error:
        raise refused(error) from error
    globals()[name] = part
    return part


def __getattr__(name: str) -> Any:
    if name not in _PARTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _part(name)


def versions() -> dict[str, str]:
    """Versions of all packages that may affect results, for the provenance of a file.

    SLEPc and gmsh are among them if they are loaded: others had no part in the results.
    """
    versions_of_parts = {"dolfinx": _version("dolfinx"), "basix": _version("basix")}
    versions_of_parts["petsc"] = ".".join(str(part) for part in _part("PETSc").Sys.getVersion())
    if slepc := globals().get("SLEPc"):
        versions_of_parts["slepc"] = ".".join(str(part) for part in slepc.Sys.getVersion())
        versions_of_parts["slepc4py"] = str(sys.modules["slepc4py"].__version__)
    if gmsh := globals().get("gmsh"):
        versions_of_parts["gmsh"] = str(gmsh.__version__)
    return {
        **versions_of_parts,
        "numpy": np.__version__,
        "h5py": h5py.__version__,
        "python": sys.version.split()[0],
        "factorisation": "mumps" if _part("HAS_MUMPS") else "petsc",
    }


def _version(name: str) -> str:
    """Version of a package: its own word, or the name of its folder of metadata if not loaded."""
    spec = find_spec(name)
    if name not in sys.modules and spec is not None and spec.origin is not None:
        for folder in Path(spec.origin).parent.parent.glob(f"*{name}*-*-info"):
            package, version = folder.name.split("-")[:2]
            if package in (name, f"fenics_{name}", f"{name}_solver_real"):
                return version.removesuffix(".dist").removesuffix(".egg")
    return str(_part(name).__version__)
