"""Have results files made: check descriptions, hand their specifications to workers, wait."""

import json
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...package.common.shares import by_mesh, mesh_key
from ...package.common.temporary import temporary_sibling
from ..fenicsx_side.interpreter import find_interpreter
from ..fenicsx_side.workers import outcomes
from .entries import Entry

SpecOf = Callable[[Entry], dict[str, Any]]  # checks a description; raises InputError


@dataclass(frozen=True)
class Made:
    """What became of one description."""

    entry: Entry
    file: Path  # the results file
    status: str  # "built", "unchanged", "failed"
    error: str = ""  # for the user, naming the description
    defect: str = ""  # traceback of an error that is none of the user's


@dataclass(frozen=True)
class Request:
    """A results file that is to be made."""

    entry: Entry
    spec: Path  # what the FE side reads; the results file appears beside it
    title: str
    mesh: str  # equal for equal meshes


def write_specs(
    entries: Sequence[Entry], folder: Path, spec_of: SpecOf
) -> tuple[list[Request], list[Made]]:
    """Check descriptions and write folder/<name>/<name>.json; those that are wrong have failed."""
    requests, failed = [], []
    for entry in entries:
        spec_file = folder / entry.name / f"{entry.name}.json"
        try:
            spec = spec_of(entry)
        except InputError as error:
            failed.append(Made(entry, spec_file.with_suffix(".vtkhdf"), "failed", str(error)))
            continue
        spec_file.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(spec_file) as temporary:
            temporary.write_text(json.dumps(spec, indent=1) + "\n", encoding="utf-8")
        requests.append(Request(entry, spec_file, str(spec.get("title", "")), mesh_key(spec)))
    return requests, failed


def make_files(
    requests: Sequence[Request],
    command: str,
    options: Sequence[str],
    *,
    jobs: int,
    done: Callable[[Made], None],
    progress: Callable[[str], None],
) -> None:
    """Make the results files on `jobs` workers.

    Parameters
    ----------
    command, options : of the preprocessor
    done : told of each file as it comes
    progress : told what a worker begins

    Raises
    ------
    InputError : there is no FEniCSx, or the preprocessor does not start.
    """
    if not requests:
        return
    by_spec = {str(request.spec): request.entry for request in requests}
    groups = by_mesh((request.spec, request.mesh) for request in requests)
    python = find_interpreter()
    lines = outcomes(groups, python, command, options, jobs=jobs, progress=progress)
    with closing(lines) as found:
        for line in found:
            entry = by_spec[line["spec"]]
            error = f"{entry.where}: {line['error']}" if line["error"] else ""
            done(Made(entry, Path(line["file"]), line["status"], error, line["defect"]))
