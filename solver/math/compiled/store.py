"""The folder in which machine code is kept: one file per function and types of arguments.

A file is named after the digest of all that it depends on, so that nothing in it is ever out of
date. It begins with the digest of what follows; a damaged one is as good as none.
"""

import contextlib
import hashlib
import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any

MOST_FILES = 2000  # of about 20 kB
_DAY = 86400.0
_TOUCHED = 7 * _DAY  # files in use are marked as such so often


def folder() -> Path | None:
    """Return the folder of compiled code; None if the user has no home."""
    chosen = os.environ.get("PLYMOTION_CACHE")
    if chosen:
        return Path(chosen) / "code"
    try:
        return Path.home() / ".cache" / "plymotion" / "code"
    except RuntimeError:
        return None


def read(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Return the description and the object code kept under `key`; None if there is none."""
    where = folder()
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
    if hashlib.sha256(rest).hexdigest().encode() != checksum:
        return None
    head, _, code = rest.partition(b"\n")
    return json.loads(head), code


def write(key: str, description: dict[str, Any], code: bytes) -> bool:
    """Keep object code; tell whether that was possible."""
    where = folder()
    if where is None:
        return False
    rest = json.dumps(description).encode() + b"\n" + code
    data = hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest
    try:
        where.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=where, prefix=".new-")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.replace(temporary, where / key)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
    except OSError:
        return False
    return True


def drop_old() -> None:
    """Keep the files used last, and no temporary ones of processes that were ended."""
    where = folder()
    if where is None or not where.is_dir():
        return
    now, kept = time.time(), []
    for path in where.iterdir():
        with contextlib.suppress(OSError):
            age = now - path.stat().st_mtime
            if path.name.startswith(".new-"):
                if age > _DAY:
                    path.unlink()
            else:
                kept.append((age, path))
    for _, path in sorted(kept)[MOST_FILES:]:
        with contextlib.suppress(OSError):
            path.unlink()
