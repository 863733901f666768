"""Objects of files that were read and found good before.

Reading and checking a package takes 0.05 s, most of it in calls of h5py, and 0.2 s if it has 30
modes with second-order fields; its object comes back from the user's cache in 1 to 10 ms. The key
is the digest of every byte of the file and of the sources of this folder, so that nothing is left
unchecked: other bytes, or other checks, are other keys.
"""

import hashlib
import pickle
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...math.disk_cache import DiskCache

MOST_FILES, MOST_BYTES = 200, 800_000_000
LARGEST = 32_000_000  # bytes of a file
_OBJECTS = DiskCache("packages", MOST_FILES, MOST_BYTES)


@cache
def _reader() -> bytes:
    """Return what the reading depends on, apart from the file."""
    root = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256(f"{sys.version} {np.__version__}".encode())
    for source in sorted(root.rglob("*.py")):
        digest.update(source.relative_to(root).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.digest()


def key_of(path: Path) -> str | None:
    """Return the key of a file; None if it cannot be read, or is too large to be kept."""
    try:
        if path.stat().st_size > LARGEST:
            return None
        return hashlib.sha256(_reader() + path.read_bytes()).hexdigest()
    except OSError:
        return None


def recall(key: str | None, kind: str) -> Any:
    """Return the object of a file of this kind; None if it was not kept.

    Whoever can write into the user's cache can run code as the user: machine code is there too.
    """
    content = _OBJECTS.read(f"{key}-{kind}") if key is not None else None
    return pickle.loads(content) if content is not None else None


def keep(key: str | None, kind: str, found: Any) -> None:
    """Keep the object of a file that has no findings."""
    if key is None:
        return
    content = pickle.dumps(found, protocol=5)
    if len(content) <= LARGEST:
        _OBJECTS.write(f"{key}-{kind}", content)
