"""Packages that were read before come back, large ones from the memory of the process."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.errors import PackageError
from plymotion.solver.package.body.reader import read_package
from plymotion.solver.package.common import read_before

KIND = "modal_package"


@pytest.fixture
def package(repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package that is too large for the user's cache, which is empty."""
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(read_before, "MOST_BYTES", 1000)
    monkeypatch.setattr(read_before, "_LARGE", {})
    shipped = sorted((repository / "tests/packages/slider-crank").glob("*.vtkhdf"))
    return Path(shutil.copy(shipped[0], tmp_path))


def test_a_large_package_is_read_once(package: Path, tmp_path: Path) -> None:
    first = read_package(package)
    key = read_before.key_of(package)
    assert read_before.recall(key, KIND) is not None
    assert not list((tmp_path / "cache").rglob("*modal*"))
    second = read_package(package)
    assert np.array_equal(second.stiffness, first.stiffness)
    second.stiffness[:] = 0.0  # nobody else has this array
    assert np.array_equal(read_package(package).stiffness, first.stiffness)


def test_other_bytes_are_read_again(package: Path) -> None:
    read_package(package)
    content = bytearray(package.read_bytes())
    content[len(content) // 2] ^= 0xFF
    package.write_bytes(content)
    assert read_before.recall(read_before.key_of(package), KIND) is None
    package.write_bytes(content[: len(content) // 2])
    with pytest.raises(PackageError):
        read_package(package)


def test_the_last_ones_used_stay(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(read_before, "MOST_IN_MEMORY", 3 * 8200)
    names = ["a", "b", "c"]
    for name in names:
        read_before.keep(name, KIND, np.full(1000, 1.0))
    assert read_before.recall("a", KIND) is not None
    read_before.keep("d", KIND, np.full(1000, 2.0))
    left = [name for name in [*names, "d"] if read_before.recall(name, KIND) is not None]
    assert left == ["a", "c", "d"]
    read_before.keep("e", KIND, np.zeros(10_000))
    assert read_before.recall("e", KIND) is None
