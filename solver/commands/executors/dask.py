"""Executor of a dask cluster: workers on any number of machines, which may come and go."""

import logging
import time
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from ...errors import InputError
from .executor import LOOK_S

QUEUED = 2  # tasks for each thread of a worker: the next one lies there when one is done
CONNECT_S = 10.0  # a scheduler that does not answer is not there


class Dask:
    """Computes tasks on the workers of a scheduler.

    Parameters
    ----------
    scheduler : address, such as "tcp://node7:8786", or the scheduler's file (*.json)

    Raises
    ------
    InputError
        dask.distributed is not installed, or no scheduler answers.
    """

    def __init__(self, scheduler: str) -> None:
        try:
            from distributed import Client
            from distributed.scheduler import KilledWorker
        except ImportError as error:
            raise InputError(
                f"--scheduler {scheduler}: needs dask.distributed ({error}): "
                "pip install 'plymotion[dask]'"
            ) from error
        for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
            # The end of a scheduler is a traceback there, and an InputError of `distribute`.
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self.name = f"--scheduler {scheduler}"
        file = Path(scheduler).suffix == ".json"
        if file and not Path(scheduler).is_file():
            raise InputError(
                f"{self.name}: no such file; `dask scheduler --scheduler-file` makes it"
            )
        where = {"scheduler_file" if file else "address": scheduler}
        try:
            self._client = Client(
                **where, timeout=CONNECT_S, set_as_default=False, name="plymotion"
            )
        except (OSError, ValueError, TypeError) as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{self.name}: no dask scheduler answers there ({reason})") from error
        self._executor = self._client.get_executor(pure=False)
        self.lost: tuple[type[BaseException], ...] = (KilledWorker,)
        self._workers: list[str] = []  # addresses, one for each thread
        self._looked = 0.0

    def width(self) -> int:
        """Return two tasks for each thread of the workers that are there now."""
        if time.monotonic() - self._looked > LOOK_S or not self._workers:
            threads = self._client.nthreads()
            self._workers = [worker for worker, count in threads.items() for _ in range(count)]
            self._looked = time.monotonic()
        return max(1, QUEUED * len(self._workers))

    def submit(self, lane: int, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Begin a task; another worker than the lane's takes it if that one is gone or busy."""
        hint: dict[str, Any] = {}
        if self._workers:
            worker = self._workers[lane % len(self._workers)]
            hint = {"workers": [worker], "allow_other_workers": True}
        future: Future[Any] = self._executor.submit(function, *arguments, **hint)
        return future

    def close(self, *, at_once: bool) -> None:
        """Leave the cluster; workers finish the task that they are at."""
        self._executor.shutdown(wait=not at_once)
        self._client.close()
