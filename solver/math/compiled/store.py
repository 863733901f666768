"""The folder in which machine code is kept: one file per function and types of arguments."""

import json
from pathlib import Path
from typing import Any

from ..disk_cache import DiskCache

MOST_FILES = 2000  # of about 20 kB
_CODE = DiskCache("code", MOST_FILES)


def folder() -> Path | None:
    """Return the folder of compiled code, made if missing; None if that is not possible."""
    return _CODE.made()


def read(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Return the description and the object code kept under `key`; None if there is none."""
    content = _CODE.read(key)
    if content is None:
        return None
    head, _, code = content.partition(b"\n")
    return json.loads(head), code


def write(key: str, description: dict[str, Any], code: bytes) -> bool:
    """Keep object code; tell whether that was possible."""
    return _CODE.write(key, json.dumps(description).encode() + b"\n" + code)
