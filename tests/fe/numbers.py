"""Numbers that must be equal for every version of DOLFINx: recorded here, compared afterwards."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

_recorded: dict[str, Any] = {}


def record(name: str, array: Any) -> None:
    """Keep a number or array under a name that is unique in the session."""
    value = np.asarray(array, dtype=float)
    if not np.all(np.isfinite(value)):
        raise ValueError(f"{name}: numbers to compare must be finite, got {array}")
    if name in _recorded:
        raise ValueError(f"{name}: recorded twice")
    _recorded[name] = value.tolist()


def write(folder: Path, version: str) -> None:
    """Write what was recorded to `folder`/<version>.json."""
    if not _recorded:
        return
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{version}.json"
    part = folder / f"{version}.json.{os.getpid()}.part"
    part.write_text(json.dumps(_recorded, indent=1, sort_keys=True), encoding="utf-8")
    part.replace(target)
