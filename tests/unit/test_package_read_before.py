"""Packages that were read and found good before come from the user's cache."""

import os
import shutil
import warnings
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.package_samples import same

from plymotion.solver.math.disk_cache import DiskCache
from plymotion.solver.package import PackageError, read_package
from plymotion.solver.package.common import object_file


@pytest.fixture
def file(repository, tmp_path, monkeypatch):
    """A package, and a cache of its own."""
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "cache"))
    source = repository / "tests/packages/double-pendulum/arm.isotropic.vtkhdf"
    return Path(shutil.copy(source, tmp_path / "arm.vtkhdf"))


@pytest.fixture
def opened(monkeypatch):
    """The files that were opened by h5py."""
    found = []
    original = object_file.open_file

    def watched(path, error):
        found.append(path)
        return original(path, error)

    monkeypatch.setattr(object_file, "open_file", watched)
    return found


def kept(tmp_path):
    return sorted((tmp_path / "cache/packages").glob("*-modal_package"))


def test_the_same_object_comes_back(file, opened):
    first, second = read_package(file), read_package(file)
    assert opened == [file]
    assert same(first, second)


def test_a_copy_is_the_same_file(file, opened, tmp_path):
    """The key is the content, not the name."""
    read_package(file)
    read_package(Path(shutil.copy(file, tmp_path / "copy.vtkhdf")))
    assert len(opened) == 1


def test_an_altered_file_is_checked_again(file):
    read_package(file)
    with h5py.File(file, "r+") as h5:
        h5["modal_package/modes/stiffness"][0, 0] *= 1.5
    with pytest.raises(PackageError, match="content was altered after writing"):
        read_package(file)


def test_a_damaged_entry_is_as_good_as_none(file, opened, tmp_path):
    first = read_package(file)
    (entry,) = kept(tmp_path)
    data = entry.read_bytes()
    for damaged in (b"", data[:1000], data[:-9] + b"123456789"):
        entry.write_bytes(damaged)
        assert same(first, read_package(file))
    assert len(opened) == 4


def test_a_file_with_a_warning_warns_each_time(file, opened):
    with h5py.File(file, "r+") as h5:
        h5.attrs["format_version"] = np.array([h5.attrs["format_version"][0], 99])
    for _ in range(2):
        with pytest.warns(UserWarning, match="parts of it are not read"):
            read_package(file)
    assert len(opened) == 2


def test_no_cache_is_no_error(file, tmp_path, monkeypatch):
    (tmp_path / "cache").write_text("a file, not a folder")
    read_package(file)
    monkeypatch.delenv("PLYMOTION_CACHE")
    monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_package(file)


def test_the_folder_stays_small(file, tmp_path, monkeypatch):
    folder = tmp_path / "cache/packages"
    folder.mkdir(parents=True)
    for k in range(300):
        (folder / f"{k}-modal_package").write_bytes(b"old")
        os.utime(folder / f"{k}-modal_package", (k, k))
    read_package(file)
    assert len(kept(tmp_path)) == 200
    assert not (folder / "0-modal_package").exists()
    assert (folder / "299-modal_package").exists()


def test_the_cache_keeps_what_was_used_last_within_its_bytes(tmp_path, monkeypatch):
    """It looks again when it has written a quarter of them."""
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path))
    some = DiskCache("some", most_files=100, most_bytes=4000)
    for number in range(30):
        assert some.write(f"{number:02d}", bytes(400))
        os.utime(tmp_path / "some" / f"{number:02d}", (1e9 + number, 1e9 + number))
    names = sorted(path.name for path in (tmp_path / "some").iterdir())
    assert names[-1] == "29"
    assert names == [f"{number:02d}" for number in range(30 - len(names), 30)]
    assert sum(path.stat().st_size for path in (tmp_path / "some").iterdir()) < 1.25 * 4000
