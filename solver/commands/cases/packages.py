"""Packages of a case, built in the Python with FEniCSx unless they are up to date."""

import hashlib
import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import plymotion

from ...errors import InputError
from ...inputs.case.run_table import package_entries
from ...inputs.case.specs import dump
from ...package.common.file_digests import files_sha256
from ...package.common.temporary import write_text
from ..fenicsx_side.interpreter import find_interpreter
from ..fenicsx_side.launch import environment, importable

STAMP = "packages.record"  # of each package: what it was built from, and the file that was left


def specs_of(out: Path, runs: Sequence[str]) -> list[Path]:
    """Return the specifications of the bodies of some runs in a folder of `check`, each once."""
    found: dict[Path, None] = {}
    for run in runs:
        table = json.loads((out / "runs" / f"{run}.json").read_text(encoding="utf-8"))
        for entry in package_entries(table):
            if "inputs_sha256" in entry:
                found[out / "bodies" / f"{Path(entry['file']).stem}.json"] = None
    return list(found)


def build_packages(specs: Sequence[Path], folder: Path, *, quiet: bool = False) -> list[str]:
    """Build the packages of body specifications into a folder; return the names of those built.

    Without FEniCSx nothing is needed as long as all packages are up to date.

    Raises
    ------
    InputError
        No Python with FEniCSx, or a body that cannot be built.
    """
    before, now = _read(folder / STAMP), {spec.stem: _inputs(spec) for spec in specs}
    wanted = [
        spec
        for spec in specs
        if before.get(spec.stem) != [now[spec.stem], _left(folder / f"{spec.stem}.vtkhdf")]
    ]
    if not wanted:
        return []
    python = find_interpreter()
    folder.mkdir(parents=True, exist_ok=True)
    command = [python, "-P", "-m", "plymotion.preprocess", "body", *map(str, wanted)]
    with importable() as home:
        done = subprocess.run(
            [*command, "--out-dir", str(folder)],
            env=environment(home),
            stdout=subprocess.DEVNULL if quiet else 2,  # as standard error
        )
    for spec in wanted:
        file = folder / f"{spec.stem}.vtkhdf"
        if file.is_file() and done.returncode == 0:
            before[spec.stem] = [now[spec.stem], _left(file)]
    write_text(folder / STAMP, dump(before))
    if done.returncode < 0 or done.returncode == 130:
        raise KeyboardInterrupt
    if done.returncode != 0:
        raise InputError(f"{folder}: packages could not be built, see the messages above")
    return [spec.stem for spec in wanted]


def _read(file: Path) -> dict[str, Any]:
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _inputs(spec: Path) -> str:
    """Digest of a specification and of all sources that a package depends on."""
    return hashlib.sha256(_sources() + spec.read_bytes()).hexdigest()


def _left(file: Path) -> list[int]:
    """Size and time of a file; nothing of one that is not there."""
    try:
        found = file.stat()
    except OSError:
        return []
    return [found.st_size, found.st_mtime_ns]


def _sources() -> bytes:
    """Digest of the preprocessor, and of the parts of the solver that it imports."""
    home = Path(plymotion.__file__).resolve().parent
    folders = ("preprocess", "meshes", "solver/package", "solver/math")
    files = [file for folder in folders for file in (home / folder).rglob("*")]
    found = {f.relative_to(home).as_posix(): f for f in files if f.suffix in (".py", ".geo")}
    return files_sha256(found).encode()
