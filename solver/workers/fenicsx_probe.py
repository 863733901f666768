"""Report on FEniCSx in one Python: that Python runs this script, which prints one line of JSON.

The script imports all packages, because an installed package may not load (a complex-valued
build, a missing shared library). It compiles one form, because
DOLFINx needs a C compiler and Python's headers at run time. It is written for
Python 3.6 and later, so that it can report why an old version is not usable. Imports are
by name: the solver itself imports none of these packages.
"""

import importlib
import json
import sys

# mpi4py must be first: with the wheel it loads the MPI library that the others link to.
MODULES = ("mpi4py.MPI", "petsc4py.PETSc", "slepc4py.SLEPc", "dolfinx", "gmsh", "h5py", "scipy")


def probe() -> dict:
    """Versions and problems found: {"dolfinx": "0.9.0", "problems": {module: reason}}."""
    problems: dict = {}
    report = {"python": sys.executable, "problems": problems}
    if sys.version_info < (3, 11):
        problems["python"] = f"{sys.version_info[0]}.{sys.version_info[1]} is older than 3.11"
        return report
    loaded = {}
    for name in MODULES:
        try:
            loaded[name] = importlib.import_module(name)
        except Exception as error:  # a broken library can raise anything on import
            problems[name.split(".")[0]] = f"{type(error).__name__}: {error}"
    if "dolfinx" in loaded:
        report["dolfinx"] = loaded["dolfinx"].__version__
    if "petsc4py.PETSc" in loaded:
        numpy = importlib.import_module("numpy")
        if numpy.issubdtype(loaded["petsc4py.PETSc"].ScalarType, numpy.complexfloating):
            problems["petsc4py"] = "complex-valued build, a real-valued one is needed"
    if not problems:
        try:
            compile_form(loaded["mpi4py.MPI"])
        except Exception as error:  # any error of the compiler or the loader
            problems["compiler"] = f"{type(error).__name__}: {error}"
    return report


def compile_form(MPI) -> None:  # type: ignore[no-untyped-def]
    """Compile the length of an interval (cached on disk after the first time)."""
    ufl, fem, mesh = map(importlib.import_module, ("ufl", "dolfinx.fem", "dolfinx.mesh"))
    interval = mesh.create_unit_interval(MPI.COMM_SELF, 1)
    fem.form(fem.Constant(interval, 1.0) * ufl.dx)


if __name__ == "__main__":
    json.dump(probe(), sys.stdout)
