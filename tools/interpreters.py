"""Python interpreters of this machine that can be started."""

import glob
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path


def output(command: list[str], timeout: float = 120.0) -> str | None:
    """Standard output of a command, or None if it cannot be started or fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None


def version(python: str) -> tuple[int, int] | None:
    """(major, minor) that an interpreter reports, or None if it does not start."""
    text = output([python, "-c", "import sys; print(*sys.version_info[:2])"])
    if not text:
        return None
    major, minor = text.split()
    return int(major), int(minor)


def on_path_or_pyenv(minor_versions: tuple[int, ...]) -> Iterator[str]:
    """Candidates for Python 3.x: names on PATH first, then pyenv's folders.

    PATH has a pyenv shim for every version of pyenv, but only the selected ones start.
    Therefore the folders of pyenv are searched as well.
    """
    for minor in minor_versions:
        if found := shutil.which(f"python3.{minor}"):
            yield found
    roots = [os.environ.get("PYENV_ROOT"), output(["pyenv", "root"]), str(Path.home() / ".pyenv")]
    for root in dict.fromkeys(r.strip() for r in roots if r):
        for minor in minor_versions:
            yield from sorted(glob.glob(f"{root}/versions/3.{minor}*/bin/python3.{minor}"))


def first(minor_versions: tuple[int, ...], modules: tuple[str, ...] = ()) -> str | None:
    """The first interpreter of these versions that starts and imports the modules."""
    wanted = {(3, minor) for minor in minor_versions}
    for python in on_path_or_pyenv(minor_versions):
        if version(python) not in wanted:
            continue
        if not modules or output([python, "-c", f"import {', '.join(modules)}"]) is not None:
            return python
    return None


def say(message: str) -> None:
    """Print one line of the set-up immediately, also into a pipe."""
    print(f"setup: {message}", flush=True)


def run(command: list[str]) -> int:
    """Run a command with its output shown; exit code, or 127 if it cannot start."""
    sys.stdout.flush()
    try:
        return subprocess.run(command).returncode
    except OSError as error:
        say(f"{command[0]}: {error.strerror}")
        return 127
