"""Whole processes: processor time, wall time and peak memory, children included."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Cost:
    """What a process and its children took."""

    cpu_s: float
    wall_s: float
    peak_mb: float  # largest resident set of one process


def cost(arguments: Sequence[str], allowed: Sequence[int] = (0,)) -> Cost:
    """Run Python with arguments; raise RuntimeError at another exit code than those allowed."""
    return cost_of([sys.executable, *arguments], allowed)


def cost_of(command: Sequence[str], allowed: Sequence[int] = (0,)) -> Cost:
    """Run a command; raise RuntimeError as `cost` does."""
    environment = dict(os.environ)
    # as an installation: bytecode is kept
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile("w+") as words:
        begin = time.perf_counter()
        process = subprocess.Popen(command, env=environment, stdout=words, stderr=words)
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode not in allowed:
            words.seek(0)
            raise RuntimeError(f"{' '.join(command)}: {words.read().strip()[-2000:]}")
    # ru_maxrss is in kilobytes
    return Cost(used.ru_utime + used.ru_stime, wall, used.ru_maxrss / 1024.0)
