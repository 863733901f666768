"""Folder `resources` of an FMU: the run, its packages, names of the inputs, where the solver is.

runs/RUN.json           as `check` wrote it, with packages of this folder
bodies/*.vtkhdf         each package once
inputs.txt              one name per line, in the order of their value references
solver.txt              the Python interpreter; the folder of a checkout, or nothing
"""

import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import plymotion

from ....errors import InputError
from ....inputs.case.run_table import package_entries

INPUTS, SOLVER = "inputs.txt", "solver.txt"


def run_of(folder: Path) -> Path:
    """Return the run file. Raises InputError if there is none, or more than one."""
    found = list((folder / "runs").glob("*.json"))
    if len(found) != 1:
        raise InputError(f"{folder}: resources of an FMU: expected one run, found {len(found)}")
    return found[0]


def write_contents(run_file: Path, folder: Path) -> Path:
    """Write run and packages into `folder`; return the run file there."""
    table = json.loads(run_file.read_text(encoding="utf-8"))
    (folder / "bodies").mkdir(parents=True)
    (folder / "runs").mkdir()
    table.pop("check_packages", None)
    copied: dict[str, str] = {}  # one copy of a package that several bodies or runs share
    for entry in package_entries(table):
        file = entry["file"]
        if file not in copied:
            copied[file] = f"bodies/{len(copied)}-{Path(file).name}"
            shutil.copyfile(run_file.parent.parent / file, folder / copied[file])
        entry["file"] = copied[file]
    run = folder / "runs" / run_file.name
    run.write_text(json.dumps(table), encoding="utf-8")
    package = Path(plymotion.__file__).resolve().parent
    checkout = (package.parent / "pyproject.toml").is_file()
    home = str(package.parent) if checkout else ""
    (folder / SOLVER).write_text(f"{sys.executable}\n{home}\n", encoding="utf-8")
    return run


def write_inputs(names: Sequence[str], folder: Path) -> None:
    """Write the names of the inputs."""
    (folder / INPUTS).write_text("".join(f"{name}\n" for name in names), encoding="utf-8")
