"""What a result was computed with: versions and the command."""

import platform
import shlex
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from plymotion import __version__

from ..math.compiled.versions import numba_version


def provenance() -> dict[str, Any]:
    """Return versions, and the command if the command line started the run."""
    versions = {
        "plymotion": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    if find_spec("numba"):
        versions["numba"] = numba_version()
    name, *words = sys.argv
    if Path(name).stem not in ("plymotion", "__main__"):
        return {"versions": versions}
    return {"versions": versions, "command": shlex.join(["plymotion", *words])}
