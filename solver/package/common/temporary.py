"""Temporary names beside a file, renamed when it is complete: nothing half-written is seen."""

import contextlib
import os
import re
import secrets
import socket
from collections.abc import Iterator
from pathlib import Path

from ...interrupts import note_complete
from .replaceable import note_written, refuse_foreign

_HOST = re.sub(r"[^A-Za-z0-9]", "_", socket.gethostname()) or "_"
_OURS = re.compile(rf"\..+\.{_HOST}-(\d+)-[0-9a-f]{{8}}(\.[^.]*)?")
_cleaned: set[Path] = set()  # folders, by this process


@contextlib.contextmanager
def temporary_sibling(path: Path, *, own: bool = False) -> Iterator[Path]:
    """Yield a temporary name beside `path`; rename it to `path` on success, remove it on failure.

    Temporary files in the folder whose process was killed are removed. Raises OSError with `path`,
    and InputError for a file of others (replaceable.py); `own` says that the caller has looked.
    """
    if not own:
        refuse_foreign(path)
    _clean(path.parent)
    token = f"{_HOST}-{os.getpid()}-{secrets.token_hex(4)}"
    temporary = path.with_name(f".{path.stem}.{token}{path.suffix}")
    try:
        yield temporary
        if not own:
            note_written(path)
        os.replace(temporary, path)
        note_complete(str(path))
    except OSError as error:
        if error.filename is not None and Path(os.fsdecode(error.filename)) == temporary:
            raise OSError(error.errno, error.strerror, str(path)) from error
        if error.filename is None and error.errno is not None:
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str, *, own: bool = False, encoding: str = "utf-8") -> None:
    """Write a text file under a temporary name, then rename it; its folder is made if missing.

    ASCII gets ? for other letters. See `temporary_sibling`.
    """
    if not own:
        refuse_foreign(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(path, own=own) as temporary:
        errors = "replace" if encoding == "ascii" else "strict"
        temporary.write_text(text, encoding=encoding, errors=errors)


def _clean(folder: Path) -> None:
    """Remove what processes of this machine that are no more have left, once for each folder."""
    if folder in _cleaned:
        return
    _cleaned.add(folder)
    with contextlib.suppress(OSError):
        for file in folder.iterdir():
            found = _OURS.fullmatch(file.name)
            if found and not _alive(int(found[1])):
                file.unlink(missing_ok=True)


def _alive(process: int) -> bool:
    """Tell whether a process runs; one that has ended may still wait for its parent (Linux)."""
    try:
        os.kill(process, 0)
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except ProcessLookupError:
        return False
    except (OSError, IndexError):
        return True
    return state not in ("Z", "X")
