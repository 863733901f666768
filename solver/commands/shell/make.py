"""Have shell files made: check descriptions, hand their specifications to the FE side, wait."""

import json
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from ...errors import InputError
from ...inputs.shell.expand import load_shell
from ...package.common.container import temporary_sibling
from ...package.common.shares import by_mesh, mesh_key
from ..fenicsx_side.crew import outcomes
from ..fenicsx_side.interpreter import find_interpreter


@dataclass(frozen=True)
class Made:
    """What became of one shell."""

    description: Path
    file: Path  # the shell file
    status: str  # "built", "unchanged", "failed"
    error: str = ""  # for the user, naming the description
    defect: str = ""  # traceback of an error that is none of the user's


@dataclass(frozen=True)
class Request:
    """A shell that is to be made."""

    description: Path
    spec: Path  # what the FE side reads; the shell file appears beside it
    mesh: str  # equal for equal meshes


def write_specs(files: Sequence[Path], folder: Path) -> tuple[list[Request], list[Made]]:
    """Check descriptions and write folder/<name>/<name>.json; those that are wrong have failed.

    Raises InputError if two descriptions would write the same file.
    """
    requests: list[Request] = []
    failed: list[Made] = []
    owner: dict[str, Path] = {}
    for file in files:
        if (other := owner.setdefault(file.stem, file)) != file:
            raise InputError(
                f"{file}: its files would overwrite those of {other}; expected another name, or "
                "one at a time with --out"
            )
        spec_file = folder / file.stem / f"{file.stem}.json"
        try:
            spec = load_shell(file)
        except InputError as error:
            failed.append(Made(file, spec_file.with_suffix(".vtkhdf"), "failed", str(error)))
            continue
        spec_file.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(spec_file) as temporary:
            temporary.write_text(json.dumps(spec, indent=1) + "\n", encoding="utf-8")
        requests.append(Request(file, spec_file, mesh_key(spec)))
    return requests, failed


def make_shells(
    requests: Sequence[Request],
    *,
    force: bool,
    done: Callable[[Made], None],
    progress: Callable[[str], None],
) -> None:
    """Make the shell files, one after the other in one process of the FE side.

    Parameters
    ----------
    force : make also what is up to date
    done : told of each shell as it comes
    progress : told what begins

    Raises
    ------
    InputError : there is no FEniCSx, or the preprocessor does not start.
    """
    if not requests:
        return
    by_spec = {str(request.spec): request.description for request in requests}
    groups = by_mesh((request.spec, request.mesh) for request in requests)
    options = ["--force"] if force else []
    lines = outcomes(groups, find_interpreter(), "shell", options, progress=progress)
    with closing(lines) as found:
        for line in found:
            description = by_spec[line["spec"]]
            error = f"{description}: {line['error']}" if line["error"] else ""
            done(Made(description, Path(line["file"]), line["status"], error, line["defect"]))
