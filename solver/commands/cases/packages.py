"""Packages of a case, built in the Python with FEniCSx unless they are up to date."""

import hashlib
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import plymotion

from ...errors import InputError
from ...inputs.case.specs import dump
from ...package.common.plain_data import canonical
from ...package.common.shares import by_mesh
from ...package.common.temporary import write_text
from ..fenicsx_side.interpreter import find_interpreter
from ..fenicsx_side.workers import outcomes

STAMP = "packages.record"  # of each package: digest of its inputs, size and time of its file


def specs_of(out: Path, runs: Sequence[str], sweeps: Sequence[str] = ()) -> list[Path]:
    """Return the specifications of the bodies of runs and sweeps in a folder of `check`."""
    found: dict[Path, None] = {}
    for entry in package_entries(out, runs, sweeps):
        if "inputs_sha256" in entry:
            file = Path(entry["file"])
            folder = "sweeps/bodies" if file.parent.parent.name == "sweeps" else "bodies"
            found[out / folder / f"{file.stem}.json"] = None
    return list(found)


def package_entries(
    out: Path, runs: Sequence[str], sweeps: Sequence[str] = ()
) -> Iterator[dict[str, str]]:
    """Yield the entries of all packages that runs and sweeps read: file, and hash of its inputs."""
    for run in runs:
        table = json.loads((out / "runs" / f"{run}.json").read_text(encoding="utf-8"))
        yield from table["packages"].values()
        yield from table.get("check_packages", {}).values()
    for sweep in sweeps:
        yield from json.loads((out / "sweeps" / f"{sweep}.json").read_text("utf-8"))["packages"]


def build_packages(
    specs: Sequence[Path],
    folder: Path | None = None,
    *,
    jobs: int = 1,
    quiet: bool = False,
    keep_going: bool = False,
) -> list[str]:
    """Build the packages of body specifications; return the names of those built.

    Without FEniCSx nothing is needed as long as all packages are up to date.

    Parameters
    ----------
    folder : of the packages; None: beside the specification of each
    jobs : processes; bodies of equal sections or meshes are built by one of them
    keep_going : leave out bodies that cannot be built

    Raises
    ------
    InputError
        No Python with FEniCSx, or a body that cannot be built.
    """
    folders = dict.fromkeys(folder or spec.parent for spec in specs)
    stamps = {each: _Stamps(each) for each in folders}
    wanted = [spec for spec in specs if not stamps[folder or spec.parent].is_current(spec)]
    built: list[str] = []
    for into, stamp in stamps.items():
        here = [spec for spec in wanted if (folder or spec.parent) == into]
        if here:
            try:
                built += _built(here, into, stamp, jobs, quiet)
            finally:
                stamp.write()
    if len(built) < len(wanted) and not keep_going:
        raise InputError(f"{wanted[0].parent}: packages could not be built, see the messages above")
    return built


def _built(
    specs: Sequence[Path], folder: Path, stamps: "_Stamps", jobs: int, quiet: bool
) -> Iterator[str]:
    """Build packages into a folder; yield the name of each as it is finished."""
    groups = by_mesh((spec, _mesh_of(spec)) for spec in specs)
    words = ["--out-dir", str(folder)]
    lines = outcomes(
        groups, find_interpreter(), "body", words, jobs=jobs, progress=lambda line: None
    )
    with closing(lines) as found:
        for count, line in enumerate(found, start=1):
            spec = Path(line["spec"])
            for warning in line["warnings"]:
                text = f"warning: {spec.stem}: {warning['code']}: {warning['message']}"
                print(text, file=sys.stderr, flush=True)
            if line["status"] == "failed":
                print(line["defect"], end="", file=sys.stderr)
                print(f"error: {spec}: {line['error']}", file=sys.stderr, flush=True)
                continue
            if not quiet:
                text = f"[{count}/{len(specs)}] {spec.stem}: {line['text'] or line['status']}"
                print(text, file=sys.stderr, flush=True)
            stamps.note(spec)
            yield spec.stem


def _mesh_of(spec: Path) -> str:
    """Text that is equal for bodies of equal sections, which one process analyses once."""
    table = json.loads(spec.read_text(encoding="utf-8"))
    return canonical([table.get(key) for key in ("section", "sections", "mesh", "shell")])


class _Stamps:
    """What the packages of a folder were built from, and what each file was then."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._known = _read(folder / STAMP)

    def is_current(self, spec: Path) -> bool:
        """Tell whether the package of a specification is there as it was built from it."""
        return self._known.get(spec.stem) == self._now(spec)

    def note(self, spec: Path) -> None:
        """Note that a package was built."""
        self._known[spec.stem] = self._now(spec)

    def write(self) -> None:
        """Write the stamps of packages that are still there."""
        kept = {n: s for n, s in self._known.items() if (self.folder / f"{n}.vtkhdf").exists()}
        write_text(self.folder / STAMP, dump(kept))

    def _now(self, spec: Path) -> list[Any]:
        return [_inputs(spec), _left(self.folder / f"{spec.stem}.vtkhdf")]


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


@cache
def _sources() -> bytes:
    """Digest of the preprocessor, and of the parts of the solver that it imports."""
    home, found = Path(plymotion.__file__).resolve().parent, hashlib.sha256()
    for folder in ("preprocess", "meshes", "solver/package", "solver/math"):
        for file in sorted((home / folder).rglob("*")):
            if file.suffix in (".py", ".geo"):
                found.update(file.read_bytes())
    return found.digest()
