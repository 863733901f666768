"""Sources of FEniCSx: Debian's packages, conda, or a wheel.

Each source is a function that installs what is missing and returns the report
of the probe (solver/workers/interpreter.py), or a line that says why it cannot.
"""

import platform
import shutil
from pathlib import Path

from interpreters import first, run, say

from plymotion.solver.workers.interpreter import (
    SYSTEM_PYTHON,
    Report,
    probe,
    reasons,
    usable,
)

ROOT = Path(__file__).resolve().parent.parent
APT_INSTALL = str(ROOT / "tools" / "apt_install.sh")

SYSTEM_PACKAGES = (
    "python3-dolfinx-real",
    "python3-slepc4py-real",
    "python3-gmsh",
    "python3-h5py",
    "python3-scipy",
    "libopenblas0-serial",  # the reference BLAS takes three times as long to factorise
)
WHEEL = "dolfinx-solver-real==0.11.0.post0"
# NumPy 2.5.3 to 2.5.5 (OpenBLAS 0.3.34) crash in X'X where OPENBLAS_CORETYPE chooses Haswell or
# Zen on a processor with AVX-512, as the tests do; an emulated Haswell does not.
NUMPY = "numpy<2.5"
WHEEL_FOLDER = ROOT / ".fenicsx-0.11"
CONDA_FOLDER = ROOT / ".fenicsx-conda"
CONDA_PACKAGES = (
    "fenics-dolfinx",
    "petsc=*=*real*",
    "slepc4py",
    "python-gmsh",
    "h5py",
    "scipy",
    "c-compiler",
    "pytest",
)

# Libraries of gmsh's wheel that are missing on a machine without a desktop.
GMSH_LIBRARIES = (
    "libglu1-mesa",
    "libgl1",
    "libx11-6",
    "libxrender1",
    "libxcursor1",
    "libxfixes3",
    "libxext6",
    "libxft2",
    "libxinerama1",
    "libfontconfig1",
    "libgomp1",
)


def repaired(report: Report) -> Report:
    """The same interpreter after installing missing libraries and a compiler by apt."""
    remedies = {"gmsh": GMSH_LIBRARIES, "compiler": ("gcc", "libc6-dev")}
    symptoms = {"gmsh": "cannot open shared object file", "compiler": ""}
    # One after the other: a form is compiled only once everything is imported.
    for name, packages in remedies.items():
        problems: dict[str, str] = report["problems"]
        if name in problems and symptoms[name] in problems[name]:
            if run([APT_INSTALL, *packages]) != 0:
                return report
            report = probe(report["python"])
    return report


def from_system() -> Report | str:
    """FEniCSx of the distribution: /usr/bin/python3 with Debian's packages."""
    if not Path(SYSTEM_PYTHON).exists():
        return f"there is no {SYSTEM_PYTHON}"
    report = probe(SYSTEM_PYTHON)
    if usable(report):
        return report
    say(f"{SYSTEM_PYTHON} has {reasons(report)}; trying Debian's packages (190 MB)")
    if run([APT_INSTALL, *SYSTEM_PACKAGES]) != 0:
        return f"could not install {' '.join(SYSTEM_PACKAGES)} by apt-get (see above)"
    report = repaired(probe(SYSTEM_PYTHON))
    return report if usable(report) else f"{SYSTEM_PYTHON}: {reasons(report)}"


def from_conda() -> Report | str:
    """FEniCSx of conda-forge, in an environment of the project."""
    tool = next(filter(None, map(shutil.which, ("micromamba", "mamba", "conda"))), None)
    if tool is None:
        return "neither micromamba, mamba nor conda is on PATH"
    say(f"{CONDA_FOLDER.name}: installing FEniCSx by {tool}")
    channel = ["--override-channels", "-c", "conda-forge"]
    if run([tool, "create", "-y", "-p", str(CONDA_FOLDER), *channel, *CONDA_PACKAGES]) != 0:
        return f"{tool} failed (see above)"
    report = probe(str(CONDA_FOLDER / "bin" / "python"))
    return report if usable(report) else f"{CONDA_FOLDER.name}: {reasons(report)}"


def from_wheel() -> Report | str:
    """FEniCSx of a wheel, in an environment of the project: Linux on x86-64."""
    python = str(WHEEL_FOLDER / "bin" / "python")
    report = repaired(probe(python))
    if usable(report):
        return report
    if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        return f"{WHEEL} exists for Linux on x86-64 only"
    base = first((14, 13, 12), ("ensurepip", "venv"))
    if base is None:
        return f"{WHEEL} needs a Python 3.12, 3.13 or 3.14 and none starts here"
    say(f"{WHEEL_FOLDER.name}: installing {WHEEL} for {base}")
    if run([base, "-m", "venv", "--clear", str(WHEEL_FOLDER)]) != 0:
        return f"{base} could not make {WHEEL_FOLDER.name} (see above)"
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    if run([*pip, WHEEL, NUMPY, "gmsh", "h5py", "scipy", "pytest"]) != 0:
        return f"pip could not install {WHEEL} (see above)"
    report = repaired(probe(python))
    return report if usable(report) else f"{WHEEL_FOLDER.name}: {reasons(report)}"
