"""Find a Python with FEniCSx, or install one: find_fenicsx.py build/fenicsx.env.

Tries $FENICSX_PYTHON, python3, /usr/bin/python3 and the environments of the
project (.fenicsx-*), by importing the packages. If none is usable: Debian's packages,
conda, or the wheel. The choice is written as a line that shells can read.
"""

import glob
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from plymotion.solver.workers.interpreter import (
    SYSTEM_PYTHON,
    Report,
    present,
    probe,
    reasons,
    usable,
)

ROOT = Path(__file__).resolve().parent.parent
APT_INSTALL, INSTALL = (str(ROOT / "tools" / f"{name}.sh") for name in ("apt_install", "install"))

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

ADVICE = f"""\
setup: no FEniCSx here and none could be installed. One of these helps:
  Debian, Ubuntu:  apt-get install --no-install-recommends {" ".join(SYSTEM_PACKAGES)}
  conda:           have micromamba, mamba or conda on PATH, then  make fenicsx
  Linux x86-64:    have a Python 3.12, 3.13 or 3.14 on PATH, then  make fenicsx
  elsewhere:       make FENICSX_PYTHON=/path/to/python ...   (real-scalar DOLFINx, slepc4py, gmsh)
  without FEniCSx: make <case> PACKAGES=shipped   (uses the modal packages of the repository)"""

# Interpreters of this machine that can be started.


def output(command: list[str], timeout: float = 120.0) -> str | None:
    """Standard output of a command, or None if it cannot be started or fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None


def version(python: str) -> tuple[int, int] | None:
    """(major, minor) that an interpreter reports, or None if it does not start."""
    text = output([python, "-c", "import sys; print(*sys.version_info[:2])"])
    if not text:
        return None
    major, minor = text.split()
    return int(major), int(minor)


def on_path_or_pyenv(minor_versions: tuple[int, ...]) -> Iterator[str]:
    """Candidates for Python 3.x: names on PATH first, then pyenv's folders.

    PATH has a pyenv shim for every version of pyenv, but only the selected ones start.
    Therefore the folders of pyenv are searched as well.
    """
    for minor in minor_versions:
        if found := shutil.which(f"python3.{minor}"):
            yield found
    roots = [os.environ.get("PYENV_ROOT"), output(["pyenv", "root"]), str(Path.home() / ".pyenv")]
    for root in dict.fromkeys(r.strip() for r in roots if r):
        for minor in minor_versions:
            yield from sorted(glob.glob(f"{root}/versions/3.{minor}*/bin/python3.{minor}"))


def first(minor_versions: tuple[int, ...], modules: tuple[str, ...] = ()) -> str | None:
    """The first interpreter of these versions that starts and imports the modules."""
    wanted = {(3, minor) for minor in minor_versions}
    for python in on_path_or_pyenv(minor_versions):
        if version(python) not in wanted:
            continue
        if not modules or output([python, "-c", f"import {', '.join(modules)}"]) is not None:
            return python
    return None


def say(message: str) -> None:
    """Print one line of the set-up immediately, also into a pipe."""
    print(f"setup: {message}", flush=True)


def run(command: list[str]) -> int:
    """Run a command with its output shown; exit code, or 127 if it cannot start."""
    sys.stdout.flush()
    try:
        return subprocess.run(command).returncode
    except OSError as error:
        say(f"{command[0]}: {error.strerror}")
        return 127


# Sources of FEniCSx. Each installs what is missing and returns the report of the probe
# (solver/workers/interpreter.py), or a line that says why it cannot.


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
    base = first((14, 13, 12), ("venv",))
    if base is None:
        return f"{WHEEL} needs a Python 3.12, 3.13 or 3.14 and none starts here"
    say(f"{WHEEL_FOLDER.name}: installing {WHEEL} for {base}")
    if run([base, "-m", "venv", "--without-pip", "--clear", str(WHEEL_FOLDER)]) != 0:
        return f"{base} could not make {WHEEL_FOLDER.name} (see above)"
    if run([INSTALL, python, WHEEL, NUMPY, "gmsh", "h5py", "scipy", "pytest"]) != 0:
        return f"{WHEEL} could not be installed (see above)"
    report = repaired(probe(python))
    return report if usable(report) else f"{WHEEL_FOLDER.name}: {reasons(report)}"


def installed() -> Report | None:
    """FEniCSx from the first available source, or None with the reasons printed."""
    for source in (from_system, from_conda, from_wheel):
        result = source()
        if isinstance(result, dict):
            return result
        say(f"FEniCSx: {result}")
    return None


def record(report: Report, path: Path) -> None:
    """Write the choice: the variables FENICSX_PYTHON and DOLFINX_VERSION for a shell."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(
        f"FENICSX_PYTHON={shlex.quote(report['python'])}\n"
        f"DOLFINX_VERSION={shlex.quote(report['dolfinx'])}\n"
    )
    temporary.replace(path)


def main(path: Path) -> int:
    """Record the choice in `path`; exit code 1 if there is none."""
    report: Report | None
    if wish := os.environ.get("FENICSX_PYTHON"):
        report = probe(wish)
        if not usable(report):
            say(f"FENICSX_PYTHON={wish} cannot be used: {reasons(report)}")
            return 1
    else:
        report = present([ROOT])[0] or installed()
    if report is None:
        print(ADVICE, file=sys.stderr)
        return 1
    record(report, path)
    say(f"FEniCSx: {report['python']}, DOLFINx {report['dolfinx']}")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
