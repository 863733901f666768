"""Results files of descriptions of sections, shells and solids, made by preprocessors."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from ..errors import InputError
from ..package.common.files import refuse_foreign, temporary_sibling
from ..package.common.plain_data import by_mesh, mesh_key
from .executors import Executor, Local
from .launch import Line, keep_preprocessors, make_all, start_of

# Which descriptions a command is given.


@dataclass(frozen=True)
class Entry:
    """One description, or a variant of one; or a results file that is shown again."""

    name: str
    file: Path
    changes: dict[str, object] = field(default_factory=dict)  # dotted key -> value

    @property
    def where(self) -> str:
        """File and changes, for messages."""
        changes = ", ".join(f"{key} = {value}" for key, value in self.changes.items())
        return f"{self.file} with {changes}" if changes else str(self.file)


def entries_of(files: Iterable[Path]) -> list[Entry]:
    """One entry for each file, named after it; a file that is given twice counts once.

    Raises
    ------
    InputError : two have the same name, and so would have the same results.
    """
    known: dict[str, Path] = {}
    for file in files:
        if (other := known.setdefault(file.stem, file)) != file:
            raise InputError(
                f"{file}: its files would overwrite those of {other}; expected another name, or "
                "one at a time with --out"
            )
    return [Entry(name, file) for name, file in known.items()]


# Have results files made: check descriptions, hand out their specifications, wait.

SpecOf = Callable[[Entry], Mapping[str, object]]  # checks a description; raises InputError


@dataclass(frozen=True)
class Made:
    """What became of one description."""

    entry: Entry
    file: Path  # the results file
    status: str  # "built", "unchanged", "failed"
    error: str = ""  # for the user, naming the description
    defect: str = ""  # traceback of an internal error


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
    """Check descriptions and write folder/<name>/<name>.json; those that are wrong have failed.

    Parameters
    ----------
    entries : descriptions to make
    folder : folder of the results
    spec_of : checks a description and returns its specification
    """
    requests, failed = [], []
    for entry in entries:
        spec_file = folder / entry.name / f"{entry.name}.json"
        try:
            if entry.name in (".", ".."):  # "...toml": its folder would be that of the others
                raise InputError(f"{entry.file}: expected a file with a name before its ending")
            spec = spec_of(entry)
        except InputError as error:
            failed.append(Made(entry, spec_file.with_suffix(".vtkhdf"), "failed", str(error)))
            continue
        refuse_foreign(spec_file)
        refuse_foreign(spec_file.with_suffix(".vtkhdf"))  # before the work
        spec_file.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(spec_file) as temporary:
            temporary.write_text(json.dumps(spec, indent=1) + "\n", encoding="utf-8")
        requests.append(Request(entry, spec_file, str(spec.get("title", "")), mesh_key(spec)))
    return requests, failed


def made_file(entry: Entry, command: str, spec_of: SpecOf, folder: Path, *, force: bool) -> Path:
    """Return the results file of one description, made unless it is up to date.

    The preprocessor stays loaded for the next call, for a minute.

    Parameters
    ----------
    entry : the description
    command : name of the preprocessor
    spec_of : checks a description and returns its specification
    folder : folder of the results
    force : make what is up to date

    Raises
    ------
    InputError : the description is wrong, there is no FEniCSx, or the analysis fails.
    """
    keep_preprocessors()
    (made,) = made_files([entry], command, ["--force"] if force else [], spec_of, folder)
    if made.status == "failed":
        raise InputError(made.error)
    return made.file


def made_files(
    entries: Sequence[Entry],
    command: str,
    options: Sequence[str],
    spec_of: SpecOf,
    folder: Path,
    *,
    jobs: int = 1,
    ranks: int = 1,
) -> list[Made]:
    """Make results files without a word; return what became of each, wrong descriptions first.

    Parameters
    ----------
    entries, command, spec_of, folder : as of `made_file`
    options : of the preprocessor
    jobs : preprocessors of this machine at a time
    ranks : as of `make_files`

    Raises
    ------
    InputError : there is no FEniCSx, or the preprocessor does not start.
    """
    requests, made = write_specs(entries, folder, spec_of)
    workers = partial(Local, jobs, threads=True)
    make_files(
        requests,
        command,
        options,
        executor=workers,
        done=made.append,
        progress=lambda _: None,
        ranks=ranks,
    )
    return made


def make_files(
    requests: Sequence[Request],
    command: str,
    options: Sequence[str],
    *,
    executor: Callable[[], Executor],
    done: Callable[[Made], None],
    progress: Callable[[str], None],
    ranks: int = 1,
) -> None:
    """Make the results files.

    Parameters
    ----------
    command, options : of the preprocessor
    executor : where; asked for if there is anything to do
    done : called with each file when it is complete
    progress : called with what a worker begins
    ranks : processes of an MPI job that all call this and share each analysis

    Raises
    ------
    InputError : there is no FEniCSx, or the preprocessor does not start.
    """
    if not requests:
        return
    by_spec = {request.spec: request.entry for request in requests}

    def made(spec: Path, line: Line) -> None:
        entry = by_spec[spec]
        error = f"{entry.where}: {line['error']}" if line["error"] else ""
        done(Made(entry, spec.with_suffix(".vtkhdf"), line["status"], error, line["defect"]))

    groups = by_mesh((request.spec, request.mesh) for request in requests)
    start = start_of(command, options, place := executor(), ranks)
    make_all(groups, start, executor=place, done=made, progress=progress)
