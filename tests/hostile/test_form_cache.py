"""Compiled forms of DOLFINx: what a killed process leaves does not stop the next one."""

import os
import signal
import subprocess
import sys

import pytest

pytest.importorskip("fcntl")
form_cache = pytest.importorskip("plymotion.preprocess.form_cache")

WHOLE = ("a.c", "a.c.cached", "a.cpython-311.so", "a.o")
HALF = ("b.c", "b.o", "c.c", "c.c.cached")
USER = (
    "import sys, time; from pathlib import Path\n"
    "from plymotion.preprocess.form_cache import hold\n"
    "lock = hold(Path(sys.argv[1])); print('held', flush=True); time.sleep(60)\n"
)


def _files(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != form_cache.LOCK)


def test_what_is_incomplete_goes_when_nobody_compiles(tmp_path):
    for name in (*WHOLE, *HALF):
        (tmp_path / name).write_text("")
    with subprocess.Popen(
        [sys.executable, "-c", USER, str(tmp_path)], stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout.readline() == "held\n"
        assert _files(tmp_path) == sorted(WHOLE)
        (tmp_path / "b.c").write_text("")  # the other process compiles
        form_cache.hold(tmp_path).close()
        assert "b.c" in _files(tmp_path)
        os.kill(other.pid, signal.SIGKILL)
        other.wait()
        form_cache.hold(tmp_path).close()
        assert _files(tmp_path) == sorted(WHOLE)
