"""Settings that every test shares, in both environments."""

import os
import sys
from pathlib import Path

import pytest

# Small matrices: threads of the linear algebra only get into each other's way.
# Set before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parent.parent

try:
    from hypothesis import settings
except ModuleNotFoundError:  # the FE environments have no hypothesis and need none
    pass
else:
    # The same examples on every machine, and no failure because one is slow.
    settings.register_profile("plymotion", derandomize=True, deadline=None)
    settings.load_profile("plymotion")


@pytest.fixture(scope="session")
def repository() -> Path:
    """The repository's root folder."""
    return ROOT


@pytest.fixture(scope="session")
def tools(repository: Path) -> Path:
    """The folder of the repository's tools, importable as top-level modules."""
    folder = repository / "tools"
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    return folder
