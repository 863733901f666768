"""Folders of the user's cache: one file per key, each beginning with the digest of what follows.

A key is the digest of all that the content depends on, so that nothing is ever out of date; a
damaged file is as good as none.
"""

import contextlib
import hashlib
import math
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

_HOUR = 3600.0  # a temporary file of this age is that of a process that was ended
_TOUCHED = 7 * 24 * _HOUR  # files in use are marked as such so often
_room: dict[Path, float] = {}  # bytes that this process may write before it looks again


@dataclass(frozen=True)
class DiskCache:
    """One folder of the cache: $PLYMOTION_CACHE/NAME, or ~/.cache/plymotion/NAME."""

    name: str
    most_files: int
    most_bytes: float = math.inf  # of all files

    def folder(self) -> Path | None:
        """Return the folder; None if the user has no home."""
        chosen = os.environ.get("PLYMOTION_CACHE")
        if chosen:
            return Path(chosen) / self.name
        try:
            return Path.home() / ".cache" / "plymotion" / self.name
        except RuntimeError:
            return None

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
        where = self.folder()
        if where is None:
            return False
        try:
            where.mkdir(parents=True, exist_ok=True)
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
