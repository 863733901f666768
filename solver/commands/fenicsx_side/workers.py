"""Several workers process the specifications of a batch, each mesh on one worker if possible."""

import queue
from collections import deque
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

from ...errors import InputError
from .launch import CLEANUP_TIMEOUT, Line, Worker, importable

START_FAILED = 2  # exit code of a preprocessor that cannot start
MOST_CRASHES = 3  # number of crashes without a result in between after which the batch is aborted
END_TIMEOUT = 10.0  # time for an idle worker to end [s]


class Work:
    """Remaining files, in groups of equal mesh."""

    def __init__(self, groups: Sequence[Sequence[Path]]) -> None:
        self._free = deque(deque(group) for group in groups if group)
        self._taken: dict[Worker, deque[Path]] = {}

    def next(self, worker: Worker) -> Path | None:
        """The next file for a worker: of its own group, of a new group, or of half of another
        worker's."""
        if not self._taken.get(worker):
            if self._free:
                self._taken[worker] = self._free.popleft()
            else:
                largest = max(self._taken.values(), key=len, default=deque[Path]())
                half = deque[Path]()
                for _ in range((len(largest) + 1) // 2):
                    half.appendleft(largest.pop())
                self._taken[worker] = half
        own = self._taken[worker]
        return own.popleft() if own else None

    def release(self, worker: Worker) -> None:
        """Return the remaining files of a lost worker to the others."""
        left = self._taken.pop(worker, None)
        if left:
            self._free.appendleft(left)


def outcomes(
    groups: Sequence[Sequence[Path]],
    python: str,
    command: str,
    options: Sequence[str],
    *,
    jobs: int = 1,
    progress: Callable[[str], None],
) -> Generator[Line, None, None]:
    """Make the file of every specification; yield each outcome when it arrives.

    If a worker crashes, only its current file is lost.

    Parameters
    ----------
    groups : specification files, those of equal mesh together
    python : interpreter with FEniCSx
    command, options : of the preprocessor
    jobs : number of workers
    progress : called with the step that a worker begins

    Raises
    ------
    InputError : the preprocessor does not start.
    """
    work = Work(groups)
    received: queue.SimpleQueue[tuple[Worker, Line | None]] = queue.SimpleQueue()
    at: dict[Worker, Path] = {}
    workers: list[Worker] = []
    crashes = 0
    timeout = 0.0

    def assign(worker: Worker) -> None:
        spec = work.next(worker)
        if spec is None:
            worker.close()
        else:
            at[worker] = spec
            worker.request(spec)

    with importable() as folder:

        def start() -> None:
            worker = Worker(python, folder, command, options, lambda *line: received.put(line))
            workers.append(worker)
            assign(worker)

        try:
            for _ in range(min(jobs, sum(map(len, groups)))):
                start()
            while at:
                worker, line = received.get()
                if line is None:
                    if worker not in at:
                        continue  # ended on request
                    spec, reason = at.pop(worker), worker.end_reason()
                    crashes += 1
                    if worker.exit_code() == START_FAILED or crashes == MOST_CRASHES:
                        raise InputError(f"{python}: the preprocessor does not run: {reason}")
                    work.release(worker)
                    yield _crashed(spec, reason)
                    start()
                elif "progress" in line:
                    progress(f"{at[worker].stem}: {line['progress']}")
                else:
                    crashes = 0
                    del at[worker]
                    yield line
                    assign(worker)
            timeout = END_TIMEOUT
        finally:
            if not timeout:  # interrupted, or an error: stop all workers
                for worker in workers:
                    worker.interrupt()
            for worker in workers:
                worker.end(timeout or CLEANUP_TIMEOUT)


def _crashed(spec: Path, reason: str) -> Line:
    return {
        "spec": str(spec),
        "file": str(spec.with_suffix(".vtkhdf")),
        "status": "failed",
        "seconds": 0.0,
        "warnings": [],
        "error": f"the preprocessor ended unexpectedly: {reason}",
        "defect": "",
    }
