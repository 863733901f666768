"""Find a Python with FEniCSx by importing the packages that the preprocessor needs."""

import json
import os
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import NotRequired, TypedDict

import plymotion

from ..errors import COMPILER, HOW_TO_INSTALL_FENICSX, InputError

SYSTEM_PYTHON = "/usr/bin/python3"
PROBE = Path(__file__).with_name("fenicsx_probe.py")
CHOICE = Path("build") / "fenicsx.env"  # file in a checkout, written by `make fenicsx`

# Variables of this process's MPI job, if any: other processes must not join it unasked.
LAUNCHER = ("OMPI_", "PMI_", "PMIX_", "MPI_LOCAL")


class Report(TypedDict):
    """What `probe` finds: an interpreter, the version of its DOLFINx, and problems by module."""

    python: str
    dolfinx: NotRequired[str]
    problems: dict[str, str]


_usable: set[str] = set()  # interpreters that this process has probed


def probe(python: str) -> Report:
    """Report on the imports of an interpreter; it has the problem "python" if it does not start."""
    outside = {k: v for k, v in os.environ.items() if not k.startswith(LAUNCHER)}
    try:
        done = subprocess.run(
            [python, str(PROBE)], capture_output=True, text=True, timeout=300, env=outside
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return {"python": python, "problems": {"python": f"does not start: {error}"}}
    for line in reversed(done.stdout.splitlines()):
        if line.startswith("{"):
            report: Report = json.loads(line)
            return report
    reason = (done.stderr.strip().splitlines() or ["no output"])[-1]
    return {"python": python, "problems": {"python": f"does not start: {reason}"}}


def usable(report: Report) -> bool:
    """True if all packages that the preprocessor needs were imported."""
    return not report["problems"]


def reasons(report: Report) -> str:
    """The problems of a report in one line: what is missing, then what is broken."""
    problems: dict[str, str] = report["problems"]
    missing = [name for name, why in problems.items() if "ModuleNotFoundError" in why]
    others = [f"{name}: {why}" for name, why in problems.items() if name not in missing]
    if "compiler" in problems:
        others.append(COMPILER)
    return "; ".join([*([f"no {', '.join(missing)}"] if missing else []), *others])


def checkouts() -> list[Path]:
    """The checkout of this code, if any; never the current folder, whose files may be anybody's."""
    here = Path(plymotion.__file__).resolve().parent.parent
    return [here] if (here / "preprocess").is_dir() else []


def candidates(folders: list[Path]) -> list[str]:
    """Candidate interpreters without duplicates: on PATH, of the system, of the checkouts."""
    own = [str(path) for folder in folders for path in sorted(folder.glob(".fenicsx-*/bin/python"))]
    on_path = shutil.which("python3") or ""
    known = [on_path if os.path.isabs(on_path) else "", SYSTEM_PYTHON, *own]  # not `.` of PATH
    return list(dict.fromkeys(filter(None, known)))


def present(folders: list[Path]) -> tuple[Report | None, list[Report]]:
    """The first usable interpreter, or None, and the reports of unusable ones."""
    refused: list[Report] = []
    for python in candidates(folders):
        report = probe(python)
        if usable(report):
            return report, refused
        refused.append(report)
    return None, refused


def recorded(folder: Path) -> str | None:
    """The interpreter that `make fenicsx` recorded for a checkout, if it still exists."""
    try:
        words = shlex.split((folder / CHOICE).read_text(encoding="utf-8"))
    except OSError:
        return None
    values = dict(word.split("=", 1) for word in words if "=" in word)
    python = values.get("FENICSX_PYTHON", "")
    return python if python and Path(python).exists() else None


def find_interpreter() -> str:
    """The Python to run the preprocessor with.

    The first of: $FENICSX_PYTHON, the interpreter that `make fenicsx` recorded, `candidates`.

    Raises
    ------
    InputError
        None has FEniCSx; the message names the missing parts of each, and the remedy.
    """
    folders = checkouts()
    known = [python for folder in folders if (python := recorded(folder))]
    if python := os.environ.get("FENICSX_PYTHON"):
        if python in _usable or python in known:  # a probe takes 0.8 s
            return python
        report = probe(python)
        if not usable(report):
            raise InputError(
                f"FENICSX_PYTHON = {python}: cannot use FEniCSx: {reasons(report)}. "
                f"{HOW_TO_INSTALL_FENICSX}"
            )
        _usable.add(python)
        return python
    if known:
        return known[0]  # it was checked when it was recorded
    interpreter, refused = present(folders)
    if interpreter is None:
        tried = "".join(f"\n  {report['python']}: {reasons(report)}" for report in refused)
        raise InputError(
            "no Python with FEniCSx found; FENICSX_PYTHON names one with real-scalar DOLFINx, "
            f"slepc4py and gmsh. Tried:{tried}\n{HOW_TO_INSTALL_FENICSX}"
        )
    return str(interpreter["python"])
