"""The attack passes signals on to its tests, and goes on where it was interrupted."""

import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
from harness.hostile_profile import LONG, WAIT_S

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
TESTS = """
import os, time
from pathlib import Path

def test_first():
    Path("first").touch(exist_ok=False)

def test_second():
    while not Path("first").exists():
        time.sleep(0.05)
    Path("pid").write_text(str(os.getpid()))
    if not Path("again").exists():
        time.sleep(600.0)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM][:LONG])
def test_a_signal_to_the_tool_alone(repository, tmp_path, number):
    for name in ("tools/attack.py", "tests/harness/hostile_profile.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(repository / name, tmp_path / name)
    (tmp_path / "tests/hostile").mkdir()
    for name in ("conftest.py", "test_few.py"):
        text = (repository / "tests/hostile/conftest.py").read_text() if "conf" in name else TESTS
        (tmp_path / "tests/hostile" / name).write_text(text)
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    environment["PYTHONPATH"] = str(repository / "tests")
    words = [sys.executable, str(tmp_path / "tools/attack.py"), "-p", "no:cacheprovider"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment)
    file, end = tmp_path / "pid", time.monotonic() + WAIT_S
    while not (file.exists() and file.read_text()):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.05)
    process.send_signal(number)
    told, _ = process.communicate(timeout=WAIT_S)
    assert process.returncode == 130
    assert told.startswith("interrupted: ")
    while True:  # its workers end
        try:
            os.kill(int(file.read_text()), 0)
        except ProcessLookupError:
            break
        assert time.monotonic() < end
        time.sleep(0.05)
    (tmp_path / "again").touch()
    done = subprocess.run(words, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout  # the first is not tried again
    assert "2 tests after" in done.stderr
