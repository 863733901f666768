"""A dask cluster on this machine: real processes, for tests and measurements."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from harness.executor_samples import LOG

TESTS = Path(__file__).parents[1]


def until(true: Callable[[], object], seconds: float = 60.0) -> None:
    """Wait."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


class Cluster:
    """A scheduler of dask and its workers, as processes of their own."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "scheduler.json"
        self.log = folder / "log"
        self.log.touch()
        known = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
        path = os.pathsep.join([str(TESTS), *map(os.path.abspath, known)])  # of another folder
        self._environment = os.environ | {"PYTHONPATH": path, LOG: str(self.log)}
        self._environment["DASK_DISTRIBUTED__SCHEDULER__WORK_STEALING"] = "False"
        words = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self._folder = folder
        self.processes = [self._started("scheduler", *words, "--scheduler-file", str(self.file))]
        until(self.file.is_file)

    def _started(self, *words: str) -> subprocess.Popen:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *words],
            env=self._environment,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def worker(self) -> subprocess.Popen:
        words = ("--no-nanny", "--nthreads", "1", "--host", "127.0.0.1", "--no-dashboard")
        process = self._started("worker", "--scheduler-file", str(self.file), *words)
        self.processes.append(process)
        return process

    def noted(self) -> list[tuple[int, list[int]]]:
        """Process and members of each portion that a worker has computed."""
        lines = (list(map(int, line.split())) for line in self.log.read_text().splitlines())
        return [(pid, numbers) for pid, *numbers in lines]

    def end_workers(self) -> None:
        """Leave the scheduler alone, with an empty log."""
        while len(self.processes) > 1:
            self._end(self.processes.pop())
        self.log.write_text("")

    def close(self) -> None:
        for process in reversed(self.processes):
            self._end(process)

    @staticmethod
    def _end(process: subprocess.Popen) -> None:
        process.kill()
        process.wait()
