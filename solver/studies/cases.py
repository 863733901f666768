"""A case of a command: its runs and sweeps, and the folder of its results."""

import logging
import os
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError, few, nearest
from ..inputs.case.record import case_file, case_name
from ..package.common.files import refuse_link
from ..system.platform import POSIX, locked

if TYPE_CHECKING:
    from ..inputs.case.load import Case

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
    """Return the run asked for; if none is named the first one, or with `only` the only one."""
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
