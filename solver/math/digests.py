"""Digests of files and of our own sources: what was made from others is out of date."""

import hashlib
import os
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[2]  # where solver/, preprocess/ and meshes/ are


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file; OSError if it cannot be read."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_sha256(files: Mapping[str, Path]) -> str:
    """Return the SHA-256 of files with their names, whatever their order; OSError as above."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0".encode() + files[name].read_bytes() + b"\0")
    return digest.hexdigest()


@cache
def sources_sha256(*places: str, apart: tuple[str, ...] = ()) -> str:
    """Return the SHA-256 of our sources, of any kind, wherever they are installed.

    Parameters
    ----------
    places : folders such as `solver/math`; what is not there has no sources
    apart : files and folders in them that do not count
    """
    found = {name: _ROOT / name for name in _names(*places) if not name.startswith(apart)}
    return files_sha256(found)


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
        found = os.stat(file)
    except OSError:
        return []
    return [found.st_size, found.st_mtime_ns]


def state_since(file: Path, begin: int) -> list[int]:
    """Return `state_of` a file that was read after `begin` [ns]; one that no file has if it may
    have changed since, so that the record does not tell what was read."""
    try:
        return state_of(file) if os.stat(file).st_ctime_ns < begin else [-1]
    except OSError:
        return [-1]
