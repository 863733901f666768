"""Folders of the user's cache: one file per key, each beginning with the digest of what follows.

A key is the digest of all that the content depends on, so that nothing is ever out of date; a
damaged file is ignored. Machine code is kept here: a folder that another user could have
written into is not used (docs/security.md).
"""

import contextlib
import hashlib
import math
import os
import stat
import tempfile
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

_HOUR = 3600.0  # a temporary file of this age is that of a process that was ended
_TOUCHED = 7 * 24 * _HOUR  # files in use are marked as such so often
_checked: dict[Path, bool] = {}  # folders, by this process
_room: dict[Path, float] = {}  # bytes that this process may write before it looks again


@dataclass(frozen=True)
class DiskCache:
    """One folder of the cache: $PLYMOTION_CACHE/NAME, or ~/.cache/plymotion/NAME."""

    name: str
    most_files: int
    most_bytes: float = math.inf  # of all files

    def folder(self) -> Path | None:
        """Return the folder; None if the user has no home, or others can write there."""
        chosen = os.environ.get("PLYMOTION_CACHE")
        try:
            root = Path(chosen) if chosen else Path.home() / ".cache" / "plymotion"
        except RuntimeError:
            return None
        found = root / self.name
        return found if _is_own(root) and _is_own(found) else None

    def made(self, name: str = "") -> Path | None:
        """Return the folder, or one in it, made if missing; None if that is not possible."""
        found = self.folder()
        if found is None:
            return None
        try:
            found.parent.parent.mkdir(parents=True, exist_ok=True)
            for folder in (found.parent, found, found / name):
                folder.mkdir(mode=0o700, exist_ok=True)
        except OSError:
            return None
        return found / name if self.folder() is not None else None

    def read(self, key: str) -> bytes | None:
        """Return what is kept under `key`; None if there is nothing, or it is damaged."""
        where = self.folder()
        if where is None:
            return None
        path = where / key
        try:
            data = path.read_bytes()
            if time.time() - path.stat().st_mtime > _TOUCHED:
                os.utime(path)
        except OSError:
            if not path.is_file():
                return None
            data = path.read_bytes() if os.access(path, os.R_OK) else b""
        checksum, _, rest = data.partition(b"\n")
        return rest if hashlib.sha256(rest).hexdigest().encode() == checksum else None

    def write(self, key: str, content: bytes) -> bool:
        """Keep something; tell whether that was possible."""
        where = self.made()
        if where is None:
            return False
        try:
            handle, temporary = tempfile.mkstemp(dir=where, prefix=".new-")
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
                found = path.stat()
                age = now - found.st_mtime
                if path.name.startswith(".new-"):
                    if age > _HOUR:
                        path.unlink()
                else:
                    kept.append((age, path, found.st_size))
        total = 0
        for number, (_, path, size) in enumerate(sorted(kept)):
            total += size
            if number >= self.most_files or total > self.most_bytes:
                with contextlib.suppress(OSError):
                    path.unlink()


def _is_own(folder: Path) -> bool:
    """Tell whether nobody else can have written into a folder; a missing one is nobody else's.

    A link must be the user's own, too: in a shared folder another user could have set it.
    """
    if folder not in _checked:
        try:
            link, found = folder.lstat(), folder.stat()
        except OSError:
            return True
        user = getattr(os, "geteuid", lambda: found.st_uid)()  # Windows has other means
        writable = os.name == "posix" and found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        _checked[folder] = not writable and {link.st_uid, found.st_uid} <= {user, 0}
        if not _checked[folder] and sum(not own for own in _checked.values()) == 1:
            warnings.warn(
                f"{folder}: not used as a cache, because another user owns it or can write to it, "
                "and files in it are executed. Remove it or, if it is yours, `chmod -R go-w` it; "
                "or set PLYMOTION_CACHE to a folder of your own",
                UserWarning,
                stacklevel=2,
            )
    return _checked[folder]
