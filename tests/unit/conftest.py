"""Fixtures of the unit tests."""

import shutil
from pathlib import Path

import pytest


@pytest.fixture
def file(written: Path, tmp_path: Path) -> Path:
    """A copy of the file that the fixture `written` of a module wrote; a test may change it."""
    return Path(shutil.copy(written, tmp_path))
