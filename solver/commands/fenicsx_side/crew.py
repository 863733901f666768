"""Several workers process the specifications of a batch, each mesh on one worker if possible."""

import queue
from collections import deque
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

from ...errors import InputError
from .launch import GRACE, Line, Worker, importable

REFUSED = 2  # exit code of a preprocessor that cannot start
FRUITLESS = 3  # number of crashes without a result in between after which the batch is aborted
FAREWELL = 10.0  # time for an idle worker to end [s]


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
                richest = max(self._taken.values(), key=len, default=deque[Path]())
                half = deque[Path]()
                for _ in range((len(richest) + 1) // 2):
                    half.appendleft(richest.pop())
                self._taken[worker] = half
        own = self._taken[worker]
        return own.popleft() if own else None

    def give_back(self, worker: Worker) -> None:
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
    heard: queue.SimpleQueue[tuple[Worker, Line | None]] = queue.SimpleQueue()
    at: dict[Worker, Path] = {}
    crew: list[Worker] = []
    fruitless = 0
    patience = 0.0

    def hand(worker: Worker) -> None:
        spec = work.next(worker)
        if spec is None:
            worker.dismiss()
        else:
            at[worker] = spec
            worker.give(spec)

    with importable() as folder:

        def start() -> None:
            crew.append(Worker(python, folder, command, options, lambda *said: heard.put(said)))
            hand(crew[-1])

        try:
            for _ in range(min(jobs, sum(map(len, groups)))):
                start()
            while at:
                worker, line = heard.get()
                if line is None:
                    if worker not in at:
                        continue  # told to end
                    spec, words = at.pop(worker), worker.last_words()
                    fruitless += 1
                    if worker.exit_code() == REFUSED or fruitless == FRUITLESS:
                        raise InputError(f"{python}: the preprocessor does not run: {words}")
                    work.give_back(worker)
                    yield _crashed(spec, words)
                    start()
                elif "progress" in line:
                    progress(f"{at[worker].stem}: {line['progress']}")
                else:
                    fruitless = 0
                    del at[worker]
                    yield line
                    hand(worker)
            patience = FAREWELL
        finally:
            if not patience:  # interrupted, or an error: stop all workers
                for worker in crew:
                    worker.interrupt()
            for worker in crew:
                worker.end(patience or GRACE)


def _crashed(spec: Path, words: str) -> Line:
    return {
        "spec": str(spec),
        "file": str(spec.with_suffix(".vtkhdf")),
        "status": "failed",
        "seconds": 0.0,
        "warnings": [],
        "error": f"the preprocessor ended unexpectedly: {words}",
        "defect": "",
    }
