"""FE tests need FEniCSx and record numbers for the comparison of its versions."""

import importlib.util
import os
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

try:
    from plymotion.preprocess import fenicsx
except ImportError as error:
    MISSING: str | None = str(error)
    collect_ignore_glob = ["test_*.py"]
else:
    MISSING = None

HERE = Path(__file__).resolve().parent
# tools/core_types.py asks for a folder of its own
NUMBERS = Path(os.environ.get("PLYMOTION_FE_NUMBERS", HERE.parent.parent / "build" / "fe-numbers"))


def _load_numbers() -> ModuleType:
    # by path: a plain `import numbers` is the standard library's
    spec = importlib.util.spec_from_file_location("plymotion_fe_numbers", HERE / "numbers.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_numbers = _load_numbers()


@pytest.fixture
def record(request: pytest.FixtureRequest) -> Callable[[str, Any], None]:
    """record(name, array): these numbers must be equal on every version of DOLFINx."""
    if request.node.get_closest_marker("one_end"):
        pytest.fail("a test with the mark one_end has nothing to compare")
    return _numbers.record


def pytest_report_header() -> str | None:
    return f"FE tests not collected: {MISSING}" if MISSING else None


def pytest_sessionfinish() -> None:
    if MISSING is None:
        _numbers.write(NUMBERS, fenicsx.versions()["dolfinx"])
