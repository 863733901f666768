"""Objects of files that were read and found good before.

Reading and checking a package takes 0.05 s, most of it in calls of h5py, and 0.2 s if it has 30
modes with second-order fields; its object comes back from the user's cache in 1 to 10 ms. The key
is the digest of every byte of the file and of the sources of this folder, so that nothing is left
unchecked: other bytes, or other checks, are other keys.

An entry is a line of JSON and the bytes of its arrays: reading one runs no code, as a pickle would.
"""

import dataclasses
import hashlib
import importlib
import json
import sys
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...math.disk_cache import DiskCache, sources_sha256

MOST_FILES, MOST_BYTES = 200, 800_000_000
LARGEST = 32_000_000  # bytes of a file
_PACKAGE = __name__.removesuffix("common.read_before")  # whose dataclasses the objects are
_OBJECTS = DiskCache("packages", MOST_FILES, MOST_BYTES)


def _reader() -> bytes:
    """Return what the reading depends on, apart from the file."""
    return f"{sys.version} {np.__version__} {sources_sha256('solver/package')}".encode()


def key_of(path: Path) -> str | None:
    """Return the key of a file; None if it cannot be read, or is too large to be kept."""
    try:
        if path.stat().st_size > LARGEST:
            return None
        return hashlib.sha256(_reader() + path.read_bytes()).hexdigest()
    except OSError:
        return None


def recall(key: str | None, kind: str) -> Any:
    """Return the object of a file of this kind; None if it was not kept."""
    content = _OBJECTS.read(f"{key}-{kind}") if key is not None else None
    if content is None:
        return None
    head, _, data = content.partition(b"\n")
    return _decoded(json.loads(head), data)


def keep(key: str | None, kind: str, found: Any) -> None:
    """Keep the object of a file that has no findings."""
    if key is None:
        return
    arrays: list[bytes] = []
    try:
        head = json.dumps(_encoded(found, arrays)).encode()
    except TypeError:  # it has a part of another kind
        return
    content = b"".join([head, b"\n", *arrays])
    if len(content) <= LARGEST:
        _OBJECTS.write(f"{key}-{kind}", content)


def _encoded(value: Any, arrays: list[bytes]) -> Any:
    """Return a value as JSON; what JSON does not have is a list of its kind and its parts."""
    if value is None or isinstance(value, str | int | float):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        order: Literal["C", "F"] = "C" if value.flags.c_contiguous else "F"
        arrays.append(value.tobytes(order))
        return ["array", value.dtype.str, value.shape, order, len(arrays[-1])]
    if isinstance(value, dict):
        return ["dict", [[_encoded(part, arrays) for part in pair] for pair in value.items()]]
    if isinstance(value, tuple | list):
        return [type(value).__name__, [_encoded(part, arrays) for part in value]]
    parts = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    kind = f"{type(value).__module__}:{type(value).__name__}"
    if not kind.startswith(_PACKAGE):
        raise TypeError(kind)
    return [kind, {name: _encoded(part, arrays) for name, part in parts.items()}]


def _decoded(value: Any, data: bytes) -> Any:
    """Return the value of its JSON and of the bytes of its arrays, in the order of both."""
    rest = memoryview(data)

    def read(value: Any) -> Any:
        nonlocal rest
        if not isinstance(value, list):
            return value
        kind, parts = value[0], value[1]
        if kind == "array":
            _, dtype, shape, order, size = value
            piece, rest = rest[:size], rest[size:]
            flat = np.frombuffer(piece, dtype=np.dtype(dtype)).copy()
            return flat.reshape(shape, order=order)
        if kind == "dict":
            return {read(name): read(part) for name, part in parts}
        if kind in ("tuple", "list"):
            found = [read(part) for part in parts]
            return tuple(found) if kind == "tuple" else found
        module, name = kind.removeprefix(_PACKAGE).split(":")
        known: Any = getattr(importlib.import_module(_PACKAGE + module), name)
        if not dataclasses.is_dataclass(known):
            raise TypeError(kind)
        made: Any = known
        return made(**{key: read(part) for key, part in parts.items()})

    return read(value)
