"""A case of a command: its runs and sweeps, the folder of its results, and what is done already."""

import json
import logging
import os
import sys
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError, few, nearest
from ..inputs.case.record import case_file, case_name
from ..math.disk_cache import sources_sha256, state_of
from ..package.common.files import kept_table, refuse_foreign, refuse_link
from ..system.platform import POSIX, locked

if TYPE_CHECKING:
    from ..inputs.case.design import Case

# Which case, which of its runs and sweeps, which folder: for all commands with a case file.


def build_folder(file: Path, *, coarse: bool = False) -> Path:
    """Return build/<case>, or build/<case>-coarse, of a case file or the folder of one."""
    return Path("build") / (case_name(case_file(file)) + ("-coarse" if coarse else ""))


def chosen_runs(case: "Case", names: Sequence[str] | None) -> list[str]:
    """Return the runs asked for in the order of the case; all of them if none is named."""
    return _chosen(case, "--run", "run", names, case.runs) or list(case.runs)


def chosen_sweeps(case: "Case", names: Sequence[str] | None) -> list[str]:
    """Return the sweeps asked for in the order of the case."""
    return _chosen(case, "--sweep", "sweep", names, case.top.sweeps)


def chosen_run(case: "Case", name: str | None, *, only: bool = False) -> str:
    """Return the run asked for; if none is named the first one, or with `only` the only one.

    Parameters
    ----------
    case : checked case
    name : name of the run; None: none was named
    only : refuse if none is named and the case has several
    """
    if only and name is None and len(case.runs) > 1:
        raise InputError(f"--run: expected one of {few(case.runs)}")
    return chosen_runs(case, None if name is None else [name])[0]


def _chosen(
    case: "Case", option: str, kind: str, names: Sequence[str] | None, known: Iterable[str]
) -> list[str]:
    every = list(known)
    for name in names or ():
        if name not in every:
            hint = nearest(name, every)
            raise InputError(f"{option} {name}: {case.file} has no such {kind}{hint}")
    return [name for name in every if name in (names or ())]


# One command at a time works in the folder of a case; the others wait for it.

LOGGER = logging.getLogger(__name__)
POLL_S = 0.1


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Lock a folder, which is made if missing; the end of the process, however it ends, unlocks it.

    Without such locks (docs/platforms.md), commands are not serialised.
    """
    refuse_link(folder / "any")
    made = _make(folder)
    descriptor = os.open(folder, os.O_RDONLY) if POSIX else None  # Windows opens no folders
    try:
        announced = False
        with suppress(OSError):  # a file system without locks
            while descriptor is not None and not locked(descriptor):
                if not announced:
                    LOGGER.info("%s: waiting for another command", folder)
                announced = True
                time.sleep(POLL_S)
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)
        _remove_empty(made)


def _make(folder: Path) -> list[Path]:
    """Make a folder and those above it; return the new ones, the innermost first."""
    new = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise InputError(f"--out {folder}: expected a folder, found a file") from error
    return new


def _remove_empty(folders: list[Path]) -> None:
    """Remove folders in which a command that failed has left nothing."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


# Record of a finished command, which is skipped if its inputs and results are unchanged.
#
# Files of the user are compared by size and time, as make does: results may be large. A change of
# either only leads to the comparison by content that every stage does for itself.

RECORD = "finished.json"
MOST = 32  # commands that are remembered for a folder


def request_of(file: Path, options: dict[str, object]) -> str:
    """Return a name for what a command was asked to do."""
    return json.dumps({"case": str(file.resolve()), **options}, sort_keys=True)


def finished_before(out: Path, request: str) -> tuple[int, str] | None:
    """Return exit code and last line of an earlier command if it need not be done again."""
    try:
        entry = _commands(out)[request]
        if entry["program"] == _program() and _same(Path(), entry["inputs"]):
            return (
                (int(entry["code"]), str(entry["text"])) if _same(out, entry["results"]) else None
            )
    except (KeyError, TypeError, ValueError, AttributeError):
        pass
    return None


def refuse_foreign_record(out: Path) -> None:
    """Raise InputError if the place of the record has a file that is none."""
    if not _commands(out):
        refuse_foreign(out / RECORD)


def note_finished(
    out: Path,
    request: str,
    code: int,
    text: str,
    inputs: Mapping[Path, list[int]],
    results: Iterable[Path],
    shared: Collection[str] = (),
) -> None:
    """Remember a command.

    Parameters
    ----------
    inputs : files that it depends on, besides the program, with their states when they were read
    results : files in `out` that it has made or used
    shared : names of results that other commands add to: these must only be there
    """
    from ..package.common.files import write_text  # imports NumPy

    commands = _commands(out)
    commands.pop(request, None)
    commands[request] = {
        "code": code,
        "text": text,
        "program": _program(),
        "inputs": {str(file.absolute()): state for file, state in inputs.items()},
        "results": {
            file.relative_to(out).as_posix(): None if file.name in shared else state_of(file)
            for file in results
        },
    }
    recent = dict(list(commands.items())[-MOST:])
    write_text(out / RECORD, json.dumps({"commands": recent}) + "\n", own=True)


def _program() -> list[str]:
    """Return the digest of all sources, and the Python that runs them."""
    return [sources_sha256("solver", "preprocess", "meshes"), sys.version, sys.prefix]


def _commands(out: Path) -> dict[str, Any]:
    commands = kept_table(out / RECORD).get("commands")
    return commands if isinstance(commands, dict) else {}


def _same(folder: Path, states: dict[str, object]) -> bool:
    return all(
        state_of(folder / name) == state
        if state is not None
        else any(state_of(folder / name)[:1])  # there, and not empty
        for name, state in states.items()
    )
