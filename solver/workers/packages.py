"""Packages of a case, built in the Python with FEniCSx unless they are up to date."""

import json
import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError, few, not_by_check
from ..inputs.case.record import PackageEntry, package_entries
from ..package.common.container import has_fingerprint
from ..package.common.files import refuse_link
from ..package.common.object_file import PACKED
from ..package.common.plain_data import by_mesh, canonical
from ..package.specification import fingerprint
from ..system.platform import cores
from .executors import Executor, Local
from .launch import Line, make_all, start_of

if TYPE_CHECKING:
    from ..inputs.case.design import Case

LOGGER = logging.getLogger(__name__)


class BodiesFailed(InputError):
    """Some bodies could not be built; the others were. `reasons` has why, by specification."""

    def __init__(self, message: str, reasons: Mapping[Path, str]) -> None:
        super().__init__(message)
        self.reasons = dict(reasons)


def specs_of(out: Path, runs: Sequence[str]) -> list[Path]:
    """Return the specifications of the bodies of some runs in a folder of `check`, each once."""
    specs: dict[Path, None] = {}
    for run in runs:
        for entry in named_packages(out / "runs" / f"{run}.json"):
            if "inputs_sha256" in entry:
                specs[out / "bodies" / f"{Path(entry['file']).stem}.json"] = None
    return list(specs)


def build_needed(files: Sequence[Path]) -> None:
    """Build the packages that run and sweep files need and that are not up to date.

    Raises InputError as `named_packages` and `build_packages` do.
    """
    for folder, specs in needed_specs({file: named_packages(file) for file in files}).items():
        build_packages(specs, folder)


def prepared(case: "Case", folder: Path, name: str, packages: Path | None) -> Path:
    """Write a checked case into a folder and build what one of its runs or sweeps needs.

    Parameters
    ----------
    name : of the run or sweep file in the folder, which is returned
    packages : folder of ready packages; None: they are built if they are out of date

    Raises InputError as `build_needed`.
    """
    from ..inputs.case.write import write_case  # 0.2 s, which `packages` need not wait for

    write_case(case, folder, packages)
    if packages is None:
        build_needed([folder / name])
    return folder / name


def needed_specs(named: Mapping[Path, Sequence[PackageEntry]]) -> dict[Path, list[Path]]:
    """Return the specifications that run and sweep files need, each once, by folder.

    Parameters
    ----------
    named : run and sweep files with their `named_packages`
    """
    specs_by_folder: dict[Path, dict[Path, None]] = {}
    for file, entries in named.items():
        for entry in entries:
            if "inputs_sha256" in entry:  # others are packages of the user
                spec = file.parent.parent / Path(entry["file"]).with_suffix(".json")
                specs_by_folder.setdefault(spec.parent, {})[spec] = None
    return {folder: list(specs) for folder, specs in specs_by_folder.items()}


def named_packages(file: Path) -> list[PackageEntry]:
    """Return the entries of packages of a run or sweep file. Raises InputError."""
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        packages = table["packages"]
        entries = packages if isinstance(packages, list) else list(package_entries(table))
        if not all(isinstance(entry["file"], str) for entry in entries):
            raise ValueError("packages: expected the names of files")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise not_by_check(file, "run or sweep file", error) from error
    return entries


def build_packages(
    specs: Sequence[Path],
    folder: Path,
    *,
    executor: Callable[[], Executor] = lambda: Local(cores(), threads=True),
    packed: bool = False,
) -> list[str]:
    """Build the packages of body specifications into a folder; return the names of those built.

    Without FEniCSx nothing is needed as long as all packages are up to date.

    Parameters
    ----------
    executor : where they are built; asked for if there is anything to do
    packed : files for this process, with the ending `PACKED`

    Raises
    ------
    InputError
        No Python with FEniCSx.
    BodiesFailed
        A body cannot be built. The others are built.
    """
    tables = {spec: json.loads(spec.read_text(encoding="utf-8")) for spec in specs}
    ending = PACKED if packed else ".vtkhdf"
    wanted = {
        spec: table
        for spec, table in tables.items()
        if not has_fingerprint(folder / f"{spec.stem}{ending}", fingerprint(table))
    }
    if not wanted:
        return []
    refuse_link(folder / "any")
    folder.mkdir(parents=True, exist_ok=True)
    failed: dict[Path, str] = {}

    def done(spec: Path, line: Line) -> None:
        _tell(spec, line)
        if line["status"] == "failed" or not (folder / f"{spec.stem}{ending}").is_file():
            failed[spec] = line["error"]

    # Packages beside their specifications need no option: one process then builds those of several
    # folders, where it is kept (`kept_preprocessors`).
    beside = all(spec.parent == folder for spec in wanted)
    options = [] if beside else ["--out-dir", str(folder.resolve())]
    options += ["--packed"] * packed
    start = start_of("body", options, place := executor())
    groups = by_mesh((spec, _mesh_of(table)) for spec, table in wanted.items())
    make_all(groups, start, executor=place, done=done, progress=lambda _: None)
    if failed:
        names = few([spec.stem for spec in failed])
        raise BodiesFailed(f"{folder}: not built, see the messages above: {names}", failed)
    return [spec.stem for spec in wanted]


def _mesh_of(table: Mapping[str, Any]) -> str:
    """Text that is equal for bodies of equal sections, which one process analyses once."""
    return canonical([table.get(key) for key in ("section", "sections", "mesh", "shell", "solid")])


def _tell(spec: Path, line: Line) -> None:
    """Log what became of a package."""
    for warning in line["warnings"]:
        LOGGER.warning("warning: %s: %s: %s", spec.stem, warning["code"], warning["message"])
    if line["status"] != "failed":
        LOGGER.info("%s: %s", spec.stem, line["text"] or line["status"])
        return
    if line["defect"]:
        message = "this is an error of the preprocessor, not of the input:"
        LOGGER.error("%s%s", line["defect"], message)
    LOGGER.error("error: %s: %s", spec, line["error"])
