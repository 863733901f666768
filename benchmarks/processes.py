"""Whole processes: processor time, wall time and peak memory, children included."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Cost:
    """What a process and its children took."""

    cpu_s: float
    wall_s: float
    peak_mb: float  # largest resident set of one process
    told: str = ""  # what it printed


def cost(arguments: Sequence[str], allowed: Sequence[int] = (0,)) -> Cost:
    """Run Python with arguments; raise RuntimeError at another exit code than those allowed."""
    return cost_of([sys.executable, *arguments], allowed)


def cost_of(
    command: Sequence[str],
    allowed: Sequence[int] = (0,),
    watch: "Callable[[subprocess.Popen[str]], object] | None" = None,
) -> Cost:
    """Run a command; raise RuntimeError as `cost` does. `watch` is called as soon as it runs."""
    environment = dict(os.environ)
    # as an installation: bytecode is kept
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile("w+") as words:
        begin = time.perf_counter()
        process = subprocess.Popen(command, env=environment, stdout=words, stderr=words, text=True)
        if watch is not None:
            watch(process)
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        words.seek(0)
        told = words.read()
        if process.returncode not in allowed:
            raise RuntimeError(f"{' '.join(command)}: {told.strip()[-2000:]}")
    # ru_maxrss is in kilobytes
    return Cost(used.ru_utime + used.ru_stime, wall, used.ru_maxrss / 1024.0, told)
