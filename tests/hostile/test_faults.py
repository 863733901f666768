"""Faults at every temporary file: all files stay readable, and the same command goes on.

A process is killed, is told to end, or finds the disk full, before and after each renaming of a
temporary file: between result and summary, between figures and table, in the cache of compiled
code.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hostile_profile import LONG, count
from sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.commands.sweep.file import read_sweep
from plymotion.solver.results import read_result

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
# Strikes at the n-th renaming; n = 0: tells how many there are.
STRUCK = """
import atexit, errno, os, signal, sys
kind, place = sys.argv[1], int(sys.argv[2])
from plymotion.solver.__main__ import main
replace, told = os.replace, []
def strike(file):
    if "full" in kind:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(file))
    os.kill(os.getpid(), getattr(signal, kind.split()[1]))
def struck(old, new):
    told.append(new)
    if len(told) == place and kind.startswith("before"):
        strike(old)
    replace(old, new)
    if len(told) == place and kind.startswith("after"):
        strike(new)
os.replace = struck
if not place:
    atexit.register(lambda: print("renamed", len(told)))
sys.exit(main(sys.argv[3:]))
"""
KINDS = ["before SIGKILL", "after SIGKILL", "before SIGTERM", "after SIGTERM", "before full"]
KINDS += ["before SIGINT", "before SIGHUP"]
PLAIN = {"PLYMOTION_COMPILED": "0"}


def _struck(kind: str, place: int, words: list[str], **more: str) -> "subprocess.CompletedProcess":
    return subprocess.run(
        [sys.executable, "-c", STRUCK, kind, str(place), *words],
        env=os.environ | PLAIN | more,
        capture_output=True,
        text=True,
        timeout=600,
    )


def _commands(folder: Path) -> dict[str, list[str]]:
    build = folder / "build"
    return {
        "check": ["check", str(folder / "case.toml"), "--out", str(build)],
        "run": ["run", str(build / "runs/base.json"), "--quiet"],
        "sweep": ["sweep", str(build / "sweeps/s.json"), "--quiet"],
    }


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A case that is checked and computed, and the same with a change of the case file."""
    folder = tmp_path_factory.mktemp("faults") / "project"
    ball(folder, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]\nsignals = ["x"]')
    for words in _commands(folder).values():
        assert main(words) == 0
    return folder


def _unreadable(folder: Path) -> list[str]:
    """Files that are neither whole nor hidden."""
    found = []
    readers = {
        ".vtkhdf": read_result,
        ".h5": read_sweep,
        ".json": lambda f: json.loads(f.read_text()),
    }
    for file in folder.rglob("*"):
        if file.is_file() and not file.name.startswith("."):
            try:
                assert file.stat().st_size
                readers.get(file.suffix, Path.read_bytes)(file)
            except Exception as error:
                found.append(f"{file}: {error}")
    return found


def _names(folder: Path) -> list[str]:
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*"))


def _changed(project: Path, folder: Path, command: str) -> list[str]:
    """Copy and change the project; return a command that has to do its work again."""
    shutil.copytree(project, folder)
    case = folder / "case.toml"
    case.write_text(case.read_text().replace("t_end = 1.0", "t_end = 0.9"))
    commands = _commands(folder)
    for earlier in commands:
        if earlier == command:
            break
        assert main(commands[earlier]) == 0
    return commands[command]


def _try(project: Path, folder: Path, command: str, kind: str, place: int) -> None:
    words = _changed(project, folder, command)
    expected = _names(folder)
    done = _struck(kind, place, words)
    number = 0 if "full" in kind else int(getattr(signal, kind.split()[1]))
    codes = {0: (2,), 9: (-9,)}.get(number, (128 + number, 0))
    end = "recovered"
    if "Traceback" in done.stderr:
        end = "traceback"
    elif done.returncode not in codes:
        end = "other"
    elif left := _unreadable(folder):
        end, done.stderr = "file lost", "\n".join(left)
    elif main(words) != 0 or _names(folder) != expected or _unreadable(folder):
        end = "file lost"
    count(f"{command}: a fault, {kind} a temporary file is renamed", end)
    assert end == "recovered", f"{kind} {place}: exit {done.returncode}: {done.stderr}"


@pytest.mark.parametrize("command", ["check", "run", "sweep"])
def test_at_every_temporary_file(project, tmp_path, command):
    told = _struck("none", 0, _changed(project, tmp_path / "copy", command))
    renamed = int(told.stdout.split()[-1])
    assert renamed >= {"check": 1, "run": 2, "sweep": 3}[command]
    places = range(1, renamed + 1)
    tries = [(kind, place) for kind in KINDS for place in places]
    if LONG == 1:
        tries = [("after SIGTERM", 1) if command == "run" else ("before SIGKILL", renamed)]
    for kind, place in tries:
        # A folder for each: a process looks for hidden files once in each folder.
        _try(project, tmp_path / f"{kind}-{place}", command, kind, place)


def test_while_code_is_compiled(project, tmp_path):
    """Killed while units of the step loop go to the cache; the next run goes on from there."""
    if LONG == 1:
        pytest.skip("takes half a minute of CPU: `make attack`")
    words = [
        "run",
        str(project / "build/runs/base.json"),
        "--quiet",
        "--out",
        str(tmp_path / "out"),
    ]
    more = {"PLYMOTION_COMPILED": "1", "PLYMOTION_CACHE": str(tmp_path / "cache")}
    for kind, place in (("before SIGKILL", 2), ("after SIGKILL", 5), ("before SIGTERM", 9)):
        done = _struck(kind, place, words, **more)
        number = int(getattr(signal, kind.split()[1]))
        assert done.returncode in (-number, 128 + number), done.stderr
        assert "Traceback" not in done.stderr
        count(f"run: a fault, {kind} compiled code is kept", "recovered")
    done = _struck("none", 0, words, **more)
    assert done.returncode == 0, done.stderr
    assert not list((tmp_path / "cache").rglob(".*"))


@pytest.fixture
def small_disk(tmp_path):
    """A file system without room; root may mount one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "size=160k", "none", str(folder)]
    try:
        if subprocess.run(words, capture_output=True).returncode:
            pytest.skip("no file system can be mounted here")
    except FileNotFoundError:
        pytest.skip("there is no mount")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("command", ["check", "run", "sweep"])
def test_a_small_disk(small_disk, tmp_path, command):
    """Earlier results stay, the message says what is missing, and with room the command goes on."""
    folder = small_disk / "p"
    ball(folder, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]\nsignals = ["x"]')
    commands = {
        k: [*w, "--no-figures"] if k == "sweep" else w for k, w in _commands(folder).items()
    }
    for words in commands.values():
        assert main(words) == 0
    before = {f: f.read_bytes() for f in folder.rglob("*") if f.is_file()}
    fill = small_disk / "fill"
    ends = []
    for left in (0, 2, 6) if LONG == 2 else (0,):
        free = os.statvfs(small_disk)
        fill.write_bytes(b"x" * max(0, (free.f_bavail - left) * free.f_frsize))
        more = {"check": [], "run": [], "sweep": ["--fresh"]}[command]
        if command == "check":
            case = folder / "case.toml"
            case.write_text(before[case].decode().replace("t_end = 1.0", "t_end = 2.0"))
        done = _struck("none", 0, [*commands[command], *more], PLYMOTION_CACHE="/nonexistent")
        end = "refused" if done.returncode == 2 else "done" if done.returncode == 0 else "other"
        if "Traceback" in done.stderr:
            end = "traceback"
        if _unreadable(folder) or (
            end == "refused" and not before.keys() <= set(folder.rglob("*"))
        ):
            end = "file lost"
        count(f"{command}: a disk without room", end)
        ends.append(end)
        assert end in ("refused", "done"), done.stderr
        assert end == "done" or "No space left on device" in done.stderr
        fill.unlink()
        assert main(commands[command]) == 0
        assert not list(folder.rglob(".*"))
    assert ends[0] == "refused"
