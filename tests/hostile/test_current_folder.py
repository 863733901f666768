"""The current folder names no program, and caches of others are not used."""

import hashlib
import os
import pickle
import random
import warnings
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from harness.hostile_profile import count, tries
from harness.processes import this_python
from samples.package_samples import cantilever

from plymotion.solver.math.disk_cache import DiskCache
from plymotion.solver.package import read_package, write_package
from plymotion.solver.workers import interpreter

posix = pytest.mark.skipif(os.name != "posix", reason="rights of files")


def test_no_interpreter_of_the_current_folder(tmp_path, monkeypatch):
    """Neither recorded nor installed there, even if it looks like a checkout."""
    planted = tmp_path / ".fenicsx-0/bin/python"
    for program in (planted, tmp_path / "python3"):
        program.parent.mkdir(parents=True, exist_ok=True)
        program.write_text(f"#!/bin/sh\ntouch {tmp_path}/STRUCK\n")
        program.chmod(0o755)
    (tmp_path / "preprocess").mkdir()
    (tmp_path / "build").mkdir()
    (tmp_path / "build/fenicsx.env").write_text(f"FENICSX_PYTHON='{planted}'\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FENICSX_PYTHON", raising=False)
    monkeypatch.setenv("PATH", f".{os.pathsep}{os.environ['PATH']}")
    assert tmp_path not in interpreter.checkouts()
    every = [*interpreter.candidates(interpreter.checkouts()), *map(str, interpreter.checkouts())]
    assert not [name for name in every if not os.path.isabs(name) or str(tmp_path) in name]
    assert "python3" not in every
    assert not (tmp_path / "STRUCK").exists()


@posix
@pytest.mark.parametrize("place", [".", "some"])
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777])
def test_a_cache_that_others_can_write_to_is_not_used(tmp_path, monkeypatch, place, mode):
    root = tmp_path / "cache"
    monkeypatch.setenv("PLYMOTION_CACHE", str(root))
    (root / "some").mkdir(parents=True, mode=0o700)
    (root / place).chmod(mode)
    cache = DiskCache("some", 10)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert not cache.write("key", b"content")
        assert cache.read("key") is None
        assert cache.folder() is None
    assert len([w for w in told if "not used as a cache" in str(w.message)]) <= 1
    assert not (root / "some/key").exists()
    count("a cache of another owner, or that others can write to", "refused")


@posix
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs another owner")
@pytest.mark.parametrize("kind", ["folder", "link"])
def test_a_cache_of_another_owner_is_not_used(tmp_path, monkeypatch, kind):
    root = tmp_path / "cache"
    (tmp_path / "real").mkdir(mode=0o700)
    if kind == "link":
        root.symlink_to(tmp_path / "real")
    else:
        root.mkdir(mode=0o755)
    os.chown(root, 12345, -1, follow_symlinks=False)
    monkeypatch.setenv("PLYMOTION_CACHE", str(root))
    with pytest.warns(UserWarning, match="not used as a cache") if _first() else _none():
        assert not DiskCache("some", 10).write("key", b"content")
    assert not any((tmp_path / "real").iterdir())
    count("a cache of another owner, or that others can write to", "refused")


COMPILES = """
import numpy as np
from plymotion.solver.math.compiled import statistics
from plymotion.solver.math.rotations import rotation_into
A = np.empty((3, 3))
rotation_into(np.array([0.0, 1.0, 0.0, 0.0]), A)
print(len(statistics.compiled), len(statistics.loaded), A.ravel().tolist())
"""
HALF_TURN = "[1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0]"
OTHERS = ["root 777", "code 777", "code 1777", "root owner", "code owner", "code link"]


@posix
@pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed")
@pytest.mark.parametrize("way", OTHERS[:: tries(3, 1)])
def test_compiled_code_of_others_is_not_loaded(tmp_path, way):
    """It is compiled again instead; code in a folder of one's own is loaded."""
    root = tmp_path / "cache"
    place, kind = way.split()
    if kind != "777" and kind != "1777" and os.geteuid() != 0:
        pytest.skip("needs another owner")

    def found():
        done = this_python(
            "-P", "-c", COMPILES, more={"PLYMOTION_COMPILED": "1", "PLYMOTION_CACHE": str(root)}
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert found() == f"1 0 {HALF_TURN}"
    assert found() == f"0 1 {HALF_TURN}"
    folder = root if place == "root" else root / "code"
    if kind == "link":
        folder.rename(tmp_path / "theirs")
        folder.symlink_to(tmp_path / "theirs")
    if kind in ("owner", "link"):
        os.chown(folder, 12345, -1, follow_symlinks=False)
    else:
        folder.chmod(int(kind, 8))
    assert found() == f"1 0 {HALF_TURN}"
    count("a cache of another owner, or that others can write to", "refused")


def _first() -> bool:
    """Tell whether this process has not warned yet."""
    from plymotion.solver.math import disk_cache

    return all(disk_cache._checked.values())


def _none() -> warnings.catch_warnings:
    return warnings.catch_warnings()


@posix
def test_one_warning_of_a_process(tmp_path):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    code = "from plymotion.solver.math.disk_cache import DiskCache\n"
    code += "for name in 'abc':\n    DiskCache(name, 1).write('k', b'c')\n"
    done = this_python("-c", code, more={"PLYMOTION_CACHE": str(tmp_path / "cache")})
    assert done.stderr.count("not used as a cache") == 1
    assert "chmod -R go-w" in done.stderr
    assert not any((tmp_path / "cache").iterdir())


@posix
def test_new_caches_are_the_users_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "new/cache"))
    before = os.umask(0)
    try:
        assert DiskCache("some", 10).write("key", b"content")
    finally:
        os.umask(before)
    for folder in ("new/cache", "new/cache/some"):
        assert (tmp_path / folder).stat().st_mode & 0o777 == 0o700
    assert DiskCache("some", 10).read("key") == b"content"


def test_what_is_read_back_is_no_pickle(tmp_path, monkeypatch):
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "cache"))
    write_package(tmp_path / "p.vtkhdf", cantilever(n=5, m=2))
    read_package(tmp_path / "p.vtkhdf")
    (entry,) = (tmp_path / "cache/packages").iterdir()
    assert entry.read_bytes().split(b"\n")[1].startswith(b'["')
    sources = Path(interpreter.__file__).resolve().parents[3]
    for folder in ("solver", "preprocess", "plymotion"):
        for file in (sources / folder).rglob("*.py"):
            text = file.read_text(encoding="utf-8")
            assert "pickle.load" not in text, file
            assert "import pickle" not in text, file
            assert "allow_pickle=True" not in text, file


class Strike:
    """Leaves a file where it is unpickled."""

    def __init__(self, file):
        self.file = str(file)

    def __reduce__(self):
        return os.mkdir, (self.file,)


def test_damaged_and_planted_entries_of_a_cache(tmp_path, monkeypatch):
    """The file itself is read then; pickles are bytes like others."""
    monkeypatch.setenv("PLYMOTION_CACHE", str(tmp_path / "cache"))
    write_package(tmp_path / "p.vtkhdf", cantilever(n=5, m=2))
    sound = read_package(tmp_path / "p.vtkhdf")
    (entry,) = (tmp_path / "cache/packages").iterdir()
    whole = entry.read_bytes()
    planted = pickle.dumps(Strike(tmp_path / "STRUCK"))
    signed = hashlib.sha256(planted).hexdigest().encode() + b"\n" + planted
    chance = random.Random(6)
    for k in range(tries(20, 150)):
        place = chance.randrange(len(whole))
        bits = bytearray(whole)
        bits[place] ^= 1 << chance.randrange(8)
        kinds = [bytes(bits), whole[:place], planted, signed, b"", whole + b"x", whole[place:]]
        entry.write_bytes(kinds[k % len(kinds)])
        if kinds[k % len(kinds)] == signed:  # only the user can write here
            with pytest.raises((ValueError, LookupError, TypeError)):
                read_package(tmp_path / "p.vtkhdf")
            entry.unlink()
        found = read_package(tmp_path / "p.vtkhdf")
        assert np.array_equal(found.stiffness, sound.stiffness)
        assert np.array_equal(found.shapes_B, sound.shapes_B)
        assert not (tmp_path / "STRUCK").exists()
        count("a damaged or planted entry of a cache", "done")


@pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed")
@pytest.mark.parametrize("choice", ["1", "njit"])
def test_numba_does_not_read_the_current_folder(tmp_path, choice):
    """Its .numba_config.yaml could name a cache of pickles; without PyYAML Numba would warn."""
    pytest.importorskip("yaml")
    (tmp_path / "planted").mkdir()
    planted = f"cache_dir: {tmp_path}/planted\nshow_help: 1\n"
    (tmp_path / ".numba_config.yaml").write_text(planted)
    code = "import numpy as np\nfrom plymotion.solver.math.rotations import rotation_into\n"
    code += "A = np.empty((3, 3))\nrotation_into(np.array([0.0, 1.0, 0.0, 0.0]), A)\n"
    code += "import yaml\nfrom numba import config\n"
    code += "print(config.CACHE_DIR or None, config.SHOW_HELP, A[0])"
    done = this_python(
        "-P",
        "-W",
        "ignore:::plymotion",
        "-c",
        code,
        cwd=tmp_path,
        more={"PLYMOTION_COMPILED": choice, "PLYMOTION_CACHE": os.devnull},
    )
    assert done.stdout == "None 0 [1. 0. 0.]\n", done.stderr
    assert ".numba_config" not in done.stderr
    assert "Numba config" not in done.stderr
    assert not any((tmp_path / "planted").iterdir())


def test_figures_do_not_read_the_current_folder(tmp_path, monkeypatch):
    """Its matplotlibrc could start LaTeX."""
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nlines.linewidth: 99\n")
    code = "from plymotion.solver.report.style import house_style\nimport matplotlib\n"
    code += "with house_style():\n    print(matplotlib.rcParams['text.usetex'])"
    done = this_python("-P", "-c", code, cwd=tmp_path)
    assert done.stdout.strip() == "False", done.stderr
