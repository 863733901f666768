"""Packages of a case, built in the Python with FEniCSx unless they are up to date."""

import hashlib
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import plymotion

from ...errors import InputError, few
from ...inputs.case.run_table import package_entries
from ...inputs.case.specs import dump
from ...math.cores import cores
from ...package.common.file_digests import files_sha256
from ...package.common.plain_data import canonical
from ...package.common.replaceable import refuse_link
from ...package.common.shares import by_mesh
from ...package.common.temporary import write_text
from ..executors.executor import Executor
from ..executors.local import Local
from ..fenicsx_side.launch import Line
from ..fenicsx_side.workers import make_all, start_of
from .finished import state_of

Entry = dict[str, Any]  # file and digests of a package, as a run file has them
STAMP = "packages.record"  # of each package: what it was built from, and the file that was left


class BodiesFailed(InputError):
    """Some bodies could not be built; the others were."""


def specs_of(out: Path, runs: Sequence[str]) -> list[Path]:
    """Return the specifications of the bodies of some runs in a folder of `check`, each once."""
    found: dict[Path, None] = {}
    for run in runs:
        for entry in named_packages(out / "runs" / f"{run}.json"):
            if "inputs_sha256" in entry:
                found[out / "bodies" / f"{Path(entry['file']).stem}.json"] = None
    return list(found)


def build_needed(files: Sequence[Path], *, quiet: bool = False) -> None:
    """Build the packages that run and sweep files need and that are not up to date.

    Raises InputError as `named_packages` and `build_packages` do.
    """
    for folder, specs in needed_specs({file: named_packages(file) for file in files}).items():
        build_packages(specs, folder, quiet=quiet)


def needed_specs(named: Mapping[Path, Sequence[Entry]]) -> dict[Path, list[Path]]:
    """Return the specifications that run and sweep files need, each once, by folder.

    Parameters
    ----------
    named : run and sweep files with their `named_packages`
    """
    found: dict[Path, dict[Path, None]] = {}
    for file, entries in named.items():
        for entry in entries:
            if "inputs_sha256" in entry:  # others are packages of the user
                spec = file.parent.parent / Path(entry["file"]).with_suffix(".json")
                found.setdefault(spec.parent, {})[spec] = None
    return {folder: list(specs) for folder, specs in found.items()}


def named_packages(file: Path) -> list[Entry]:
    """Return the entries of packages of a run or sweep file. Raises InputError."""
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        packages = table["packages"]
        entries = packages if isinstance(packages, list) else list(package_entries(table))
        if not all(isinstance(entry["file"], str) for entry in entries):
            raise ValueError("packages: expected the names of files")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(
            f"{file}: not a run or sweep file ({error}); expected one written by `plymotion check`"
        ) from error
    return entries


def build_packages(
    specs: Sequence[Path],
    folder: Path,
    *,
    executor: Callable[[], Executor] = lambda: Local(cores(), threads=True),
    quiet: bool = False,
) -> list[str]:
    """Build the packages of body specifications into a folder; return the names of those built.

    Without FEniCSx nothing is needed as long as all packages are up to date.

    Parameters
    ----------
    executor : where they are built; asked for if there is anything to do

    Raises
    ------
    InputError
        No Python with FEniCSx.
    BodiesFailed
        A body cannot be built. The others are built.
    """
    before, now = _read(folder / STAMP), {spec.stem: _inputs(spec) for spec in specs}
    wanted = [
        spec
        for spec in specs
        if before.get(spec.stem) != [now[spec.stem], state_of(folder / f"{spec.stem}.vtkhdf")]
    ]
    if not wanted:
        return []
    refuse_link(folder / STAMP)
    folder.mkdir(parents=True, exist_ok=True)
    failed: list[Path] = []

    def done(spec: Path, line: Line) -> None:
        _show(spec, line, quiet=quiet)
        file = folder / f"{spec.stem}.vtkhdf"
        if line["status"] == "failed" or not file.is_file():
            failed.append(spec)
            return
        before[spec.stem] = [now[spec.stem], state_of(file)]

    start = start_of("body", ["--out-dir", str(folder.resolve())], place := executor())
    try:
        groups = by_mesh((spec, _mesh_of(spec)) for spec in wanted)
        make_all(groups, start, executor=place, done=done, progress=lambda _: None)
    finally:
        write_text(folder / STAMP, dump(before), own=True)
    if failed:
        names = few([spec.stem for spec in failed])
        raise BodiesFailed(f"{folder}: not built, see the messages above: {names}")
    return [spec.stem for spec in wanted]


def _mesh_of(spec: Path) -> str:
    """Text that is equal for bodies of equal sections, which one process analyses once."""
    table = json.loads(spec.read_text(encoding="utf-8"))
    return canonical([table.get(key) for key in ("section", "sections", "mesh", "shell", "solid")])


def _show(spec: Path, line: Line, *, quiet: bool) -> None:
    """Print what became of a package on standard error."""
    for warning in line["warnings"]:
        print(f"warning: {spec.stem}: {warning['code']}: {warning['message']}", file=sys.stderr)
    if line["status"] != "failed":
        if not quiet:
            print(f"{spec.stem}: {line['text'] or line['status']}", file=sys.stderr)
        return
    if line["defect"]:
        print(line["defect"], end="", file=sys.stderr)
        print("this is an error of the preprocessor, not of the input:", file=sys.stderr)
    print(f"error: {spec}: {line['error']}", file=sys.stderr)


def _read(file: Path) -> dict[str, Any]:
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _inputs(spec: Path) -> str:
    """Digest of a specification and of all sources that a package depends on."""
    return hashlib.sha256(_sources() + spec.read_bytes()).hexdigest()


@cache
def _sources() -> bytes:
    """Digest of the preprocessor, and of the parts of the solver that it imports."""
    home = Path(plymotion.__file__).resolve().parent
    folders = ("preprocess", "meshes", "solver/package", "solver/math")
    files = [file for folder in folders for file in (home / folder).rglob("*")]
    found = {f.relative_to(home).as_posix(): f for f in files if f.suffix in (".py", ".geo")}
    return files_sha256(found).encode()
