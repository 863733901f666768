"""One command at a time works in the folder of a case; the others wait for it."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...errors import InputError
from ...package.common.replaceable import refuse_link

POLL_S = 0.1


@contextmanager
def turn(folder: Path, *, quiet: bool = False) -> Iterator[None]:
    """Lock a folder, which is made if missing; the end of the process, however it ends, unlocks it.

    Without locks of this kind (Windows) nobody waits.
    """
    refuse_link(folder / "any")
    try:
        import fcntl
        import os
    except ImportError:
        folder.mkdir(parents=True, exist_ok=True)
        yield
        return
    made = _make(folder)
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        told = quiet
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if not told:
                    print(f"{folder}: waiting for another command", file=sys.stderr, flush=True)
                told = True
                time.sleep(POLL_S)
            except OSError:  # a file system without locks
                break
        yield
    finally:
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
