"""Commands in a process of their own that a fault strikes at a certain point.

The process says so at the moment in which it is struck: a fault that comes too late is no try.
"""

import json
import os
import shutil
import signal
import subprocess
from pathlib import Path

from harness.forks import forks
from harness.hostile_profile import WAIT_S
from harness.processes import this_python
from samples.sweep_samples import FORCE, ball

from plymotion.solver.__main__ import main
from plymotion.solver.results import read_result
from plymotion.solver.studies.sweep.file import read_sweep

# Strikes at the n-th time that it passes a point; n = 0: tells how often it does.
STRUCK = """
import errno, os, signal, sys
kind, place = sys.argv[1], int(sys.argv[2])
when, what = kind.split()
passed = 0
def passes(point, file=""):
    global passed
    passed += point == when
    if point != when or passed != place:
        return
    os.write(2, b"struck\\n")
    if what == "full":
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(file))
    os.kill(os.getpid(), getattr(signal, what))
def around(place, name, before=None, after=None):
    function = getattr(place, name)
    def struck(*words, **more):
        passes(before, words[0])
        found = function(*words, **more)
        passes(after, words[-1])
        return found
    setattr(place, name, struck)
from plymotion.solver.__main__ import main
around(os, "replace", "before", "after")
if when == "stepping":
    from plymotion.solver.checks.judge import Monitors
    around(Monitors, "__call__", after="stepping")
if when == "compiling":
    import llvmlite.binding
    around(llvmlite.binding, "parse_assembly", after="compiling")
code = main(sys.argv[3:])
if not place:
    print("passed", passed)
sys.exit(code)
"""
CHANGED = ("t_end = 1.0", "t_end = 0.9")


def struck(
    kind: str, place: int, words: list[str], **more: str
) -> "subprocess.CompletedProcess[str]":
    """Run a command and strike it: "before SIGKILL" a file is renamed, for example."""
    if more.get("PLYMOTION_COMPILED", "0") == "0":
        return forks.run(STRUCK, kind, str(place), *words, timeout=WAIT_S, **more)
    return this_python("-c", STRUCK, kind, place, *words, more=more, timeout=WAIT_S)


def times_passed(kind: str, words: list[str], **more: str) -> int:
    """Return how often a command that is not struck passes the point."""
    done = struck(kind, 0, words, **more)
    assert "struck" not in done.stderr
    return int(done.stdout.split()[-1])


def commands(folder: Path) -> dict[str, list[str]]:
    """Return the commands of a project, in their order."""
    build = folder / "build"
    return {
        "check": ["check", str(folder / "case.toml"), "--out", str(build)],
        "run": ["run", str(build / "runs/base.json"), "--quiet"],
        "sweep": ["sweep", str(build / "sweeps/s.json"), "--quiet"],
    }


def project(folder: Path) -> Path:
    """A case that is checked and computed."""
    ball(folder, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]\nsignals = ["x"]')
    for words in commands(folder).values():
        assert main(words) == 0
    return folder


def changed(project: Path, folder: Path, command: str) -> list[str]:
    """Copy and change the project; return a command that has to do its work again."""
    shutil.copytree(project, folder)
    case = folder / "case.toml"
    case.write_text(case.read_text().replace(*CHANGED))
    known = commands(folder)
    for earlier in known:
        if earlier == command:
            break
        assert main(known[earlier]) == 0
    return known[command]


def unreadable(folder: Path) -> list[str]:
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


def names(folder: Path) -> list[str]:
    """All files, hidden ones included."""
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*"))


def end_of(
    done: "subprocess.CompletedProcess[str]",
    number: int,
    folder: Path,
    words: list[str],
    expected: list[str],
) -> str:
    """Return what became of a command that was struck by a signal, or by a full disk (0).

    "done": it ended with exit code 0, and did its work all the same.

    Parameters
    ----------
    words : command of the process
    expected : names in the folder once it has done its work
    """
    if "Traceback" in done.stderr:
        return "traceback"
    code = {0: 2, 9: -9}.get(number, 128 + number)
    through = number not in (0, 9) and done.returncode == 0
    if not through and done.returncode != code:
        return "other"
    if through and names(folder) != expected:
        return "file lost"
    if left := unreadable(folder):
        done.stderr += "\n".join(left)
        return "file lost"
    if main(words) != 0 or names(folder) != expected or unreadable(folder):
        return "file lost"
    return "done" if through else "recovered"


def number_of(kind: str) -> int:
    """Return the signal of a kind of fault; 0 of a full disk."""
    name = kind.split()[-1]
    return 0 if name == "full" else int(getattr(signal, name))


def narrow_pipe(room: int) -> tuple[int, int]:
    """Return both ends of a pipe that takes `room` bytes more, then waits for its reader.

    A command that tells its progress there cannot end before the test reads.
    """
    import fcntl  # of POSIX

    reader, writer = os.pipe()
    os.write(writer, b"." * (fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096) - room))
    return reader, writer
