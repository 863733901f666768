"""What a result was computed with: versions, packages and the command."""

import platform
import shlex
import sys
from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from plymotion import __version__

from ..math.compiled.versions import numba_version
from ..package import ModalPackage


def provenance(packages: Mapping[str, ModalPackage]) -> dict[str, Any]:
    """Return versions, the digest of the inputs of each package, and the command if it started
    the run."""
    found: dict[str, Any] = {
        "versions": dict(_versions()),
        "packages": {name: p.provenance.get("inputs_sha256") for name, p in packages.items()},
    }
    name, *words = sys.argv
    if Path(name).stem in ("plymotion", "__main__"):
        found["command"] = shlex.join(["plymotion", *words])
    return found


@cache
def _versions() -> dict[str, str]:
    found = {
        "plymotion": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    if find_spec("numba"):
        found["numba"] = numba_version()
    return found
