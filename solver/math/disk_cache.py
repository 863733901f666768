"""Digests of files and of our own sources, and folders of the user's cache.

The cache has one file per key, which begins with the digest of what follows. A key is the digest of
all that the content depends on, so that nothing is ever out of date; a damaged file is ignored.
Machine code is kept here: a folder that another user could have written into is not used
(docs/security.md).
"""

import contextlib
import hashlib
import math
import os
import stat
import time
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

_ROOT = Path(__file__).resolve().parents[2]  # where solver/, preprocess/ and meshes/ are


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file; OSError if it cannot be read."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@cache
def sources_sha256(*places: str, apart: tuple[str, ...] = ()) -> str:
    """Return the SHA-256 of our sources and their names, of any kind, wherever they are installed.

    Parameters
    ----------
    places : folders such as `solver/math`; what is not there has no sources
    apart : files and folders in them that do not count
    """
    digest = hashlib.sha256()
    for name in sorted(name for name in _names(*places) if not name.startswith(apart)):
        with open(f"{_ROOT}/{name}", "rb", buffering=0) as file:  # the fastest way: there are many
            digest.update(f"{name}\0".encode() + file.read() + b"\0")
    return digest.hexdigest()


def _names(*places: str) -> Iterator[str]:
    """Yield our sources in folders, by their names below `_ROOT`."""
    for place in places:
        for folder, inner, files in os.walk(_ROOT / place):
            inner[:] = [name for name in inner if name != "__pycache__"]
            room = os.path.relpath(folder, _ROOT).replace(os.sep, "/")
            yield from (f"{room}/{name}" for name in files if name[0] != ".")


def state_of(file: Path) -> list[int]:
    """Return size and time of a file, as make compares them; nothing of one that is not there."""
    try:
        status = os.stat(file)
    except OSError:
        return []
    return [status.st_size, status.st_mtime_ns]


def state_since(file: Path, begin: int) -> list[int]:
    """Return `state_of` a file that was read after `begin` [ns]; one that no file has if it may
    have changed since, so that the record does not say what was read."""
    try:
        return state_of(file) if os.stat(file).st_ctime_ns < begin else [-1]
    except OSError:
        return [-1]


_HOUR = 3600.0  # a temporary file of this age is that of a process that was ended
_TOUCHED = 7 * 24 * _HOUR  # files in use are marked as such so often
_checked: dict[Path, bool] = {}  # folders, by this process
# the same by name, $PLYMOTION_CACHE and $HOME: a run reads a hundred files
_places: dict[tuple[str, str, str | None], Path | None] = {}
_room: dict[Path, float] = {}  # bytes that this process may write before it looks again


class DiskCache(NamedTuple):
    """One folder of the cache: $PLYMOTION_CACHE/NAME, or ~/.cache/plymotion/NAME."""

    name: str
    most_files: int
    most_bytes: float = math.inf  # of all files

    def folder(self) -> Path | None:
        """Return the folder; None if the user has no home, or others can write there."""
        chosen = os.environ.get("PLYMOTION_CACHE", "")
        key = self.name, chosen, os.environ.get("HOME")
        if key in _places:
            return _places[key]
        try:
            root = Path(chosen) if chosen else Path.home() / ".cache" / "plymotion"
        except RuntimeError:
            return None
        own = root / self.name
        place = own if _is_own(root) and _is_own(own) else None
        if own in _checked:  # it is there
            _places[key] = place
        return place

    def made(self, name: str = "") -> Path | None:
        """Return the folder, or one in it, made if missing; None if that is not possible."""
        own = self.folder()
        if own is None:
            return None
        try:
            own.parent.parent.mkdir(parents=True, exist_ok=True)
            for folder in (own.parent, own, own / name):
                folder.mkdir(mode=0o700, exist_ok=True)
        except OSError:
            return None
        return own / name if self.folder() is not None else None

    def read(self, key: str) -> bytes | None:
        """Return what is kept under `key`; None if there is nothing, or it is damaged."""
        where = self.folder()
        if where is None:
            return None
        path = where / key
        try:
            with open(path, "rb", buffering=0) as file:
                data = file.read()
                if time.time() - os.fstat(file.fileno()).st_mtime > _TOUCHED:
                    os.utime(path)
        except OSError:
            if not path.is_file():
                return None
            data = path.read_bytes() if os.access(path, os.R_OK) else b""
        checksum, _, rest = data.partition(b"\n")
        return rest if hashlib.sha256(rest).hexdigest().encode() == checksum else None

    def write(self, key: str, content: bytes) -> bool:
        """Keep something; return whether that was possible."""
        where = self.made()
        if where is None:
            return False
        temporary = where / f".new-{os.getpid()}-{time.monotonic_ns()}"  # tempfile: 4 ms to import
        try:
            handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
                os.replace(temporary, where / key)
            except BaseException:
                with contextlib.suppress(OSError):
                    os.unlink(temporary)
                raise
        except OSError:
            return False
        _room[where] = _room.get(where, 0.0) - len(content)
        if _room[where] < 0.0:
            _room[where] = 0.25 * self.most_bytes
            self._drop_old(where)
        return True

    def _drop_old(self, where: Path) -> None:
        """Keep the files used last, and no temporary ones of processes that were ended."""
        now, kept = time.time(), []
        for path in where.iterdir():
            with contextlib.suppress(OSError):
                status = path.stat()
                age = now - status.st_mtime
                if path.name.startswith(".new-"):
                    if age > _HOUR:
                        path.unlink()
                else:
                    kept.append((age, path, status.st_size))
        total = 0
        for number, (_, path, size) in enumerate(sorted(kept)):
            total += size
            if number >= self.most_files or total > self.most_bytes:
                with contextlib.suppress(OSError):
                    path.unlink()


def _is_own(folder: Path) -> bool:
    """Return whether no other user can have written into a folder; true of a missing one.

    A link must be the user's own, too: in a shared folder another user could have set it.
    """
    if folder not in _checked:
        try:
            link, target = folder.lstat(), folder.stat()
        except OSError:
            return True
        user = getattr(os, "geteuid", lambda: target.st_uid)()  # Windows has other means
        writable = os.name == "posix" and target.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        _checked[folder] = not writable and {link.st_uid, target.st_uid} <= {user, 0}
        if not _checked[folder] and sum(not own for own in _checked.values()) == 1:
            warnings.warn(
                f"{folder}: not used as a cache, because another user owns it or can write to it, "
                "and files in it are executed. Remove it or, if it is yours, `chmod -R go-w` it; "
                "or set PLYMOTION_CACHE to a folder of your own",
                UserWarning,
                stacklevel=2,
            )
    return _checked[folder]
