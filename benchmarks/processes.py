"""Whole processes: processor time, wall time and peak memory, children included."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

# A new process counts the memory of the one that started it, until it has its own program, as its
# peak. A small process in between starts the command, hands signals on and writes what it took.
LAUNCHER = """
import json, os, signal, sys
child = os.posix_spawnp(sys.argv[2], sys.argv[2:], os.environ)
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, lambda number, _: os.kill(child, number))
_, status, used = os.wait4(child, 0)
took = [status, used.ru_utime + used.ru_stime, used.ru_maxrss]
os.write(int(sys.argv[1]), json.dumps(took).encode())
"""


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
    environment: Mapping[str, str] | None = None,
) -> Cost:
    """Run a command; raise RuntimeError as `cost` does. `watch` is called as soon as it runs.

    `environment` takes the place of that of this process.
    """
    environment = dict(os.environ if environment is None else environment)
    # as an installation: bytecode is kept
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile("w+") as words:
        reading, writing = os.pipe()
        launcher = [sys.executable, "-I", "-S", "-c", LAUNCHER, str(writing), *command]
        begin = time.perf_counter()
        process = subprocess.Popen(
            launcher, env=environment, stdout=words, stderr=words, text=True, pass_fds=[writing]
        )
        os.close(writing)
        if watch is not None:
            watch(process)
        with open(reading, "rb") as stream:
            status, cpu, peak = json.loads(stream.read())
        wall = time.perf_counter() - begin
        process.wait()
        words.seek(0)
        told = words.read()
        if os.waitstatus_to_exitcode(status) not in allowed:
            raise RuntimeError(f"{' '.join(command)}: {told.strip()[-2000:]}")
    return Cost(cpu, wall, peak / 1024.0, told)  # ru_maxrss is in kilobytes
