"""Specifications of a batch, handed out to an executor: each mesh to one worker if possible."""

import json
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...inputs.common.gmsh_file import content_sha256
from ...inputs.scripts import are_refused
from ..executors.executor import Executor, Task, distribute
from ..executors.local import Local
from .interpreter import find_interpreter
from .launch import Line
from .task import Start, crashed, make, preprocessors

MESHES = (".msh", ".geo", ".py")
MOST_CRASHES = 3  # number of crashes without a result in between after which the batch is aborted


class Work:
    """Remaining files, in groups of equal mesh."""

    def __init__(self, groups: Sequence[Sequence[Path]]) -> None:
        self._free = deque(deque(group) for group in groups if group)
        self._taken: dict[int, deque[Path]] = {}

    def next(self, lane: int) -> Path | None:
        """The next file for a lane: of its own group, of a new group, or of half of another's."""
        if not self._taken.get(lane):
            if self._free:
                self._taken[lane] = self._free.popleft()
            else:
                largest = max(self._taken.values(), key=len, default=deque[Path]())
                half = deque[Path]()
                for _ in range((len(largest) + 1) // 2):
                    half.appendleft(largest.pop())
                self._taken[lane] = half
        own = self._taken[lane]
        return own.popleft() if own else None


class _Specifications:
    """The source of an executor (executors/executor.py)."""

    def __init__(self, work: Work, start: Start, done: Callable[[Path, Line], None]) -> None:
        self._work, self._start, self._done = work, start, done
        self._crashes = 0

    def next(self, lane: int, width: int) -> Task | None:
        """Return the next specification for a lane."""
        spec = self._work.next(lane)
        return None if spec is None else Task(make, (self._start, spec.resolve()), spec)

    def took(self, task: Task, result: Any) -> None:
        """Report an outcome. Raises InputError: the preprocessor crashes all the time."""
        if result["status"] == "built" and (changed := _changed_mesh(task.content)):
            # Nobody knows which content was read: the file would be taken for that of the first.
            task.content.with_suffix(".vtkhdf").unlink(missing_ok=True)
            words = f"{changed}: was changed while it was analysed; the same command does it again"
            result = result | {"status": "failed", "error": words}
        self._crashes = self._crashes + 1 if "crashed" in result else 0
        if self._crashes == MOST_CRASHES:
            raise InputError(f"the preprocessor does not run: {result['crashed']}")
        self._done(task.content, result)

    def lost(self, task: Task) -> None:
        """Report a file whose worker died."""
        self._done(task.content, crashed("its worker died"))


def _changed_mesh(spec: Path) -> str:
    """Return a mesh or script that is not as its specification has read it; "" if there is none."""
    pending: list[Any] = [json.loads(spec.read_text(encoding="utf-8"))]
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            name, digest = value.get("file"), value.get("sha256")
            if isinstance(name, str) and isinstance(digest, str) and name.endswith(MESHES):
                file = Path(name)
                if not file.is_file() or content_sha256(file) != digest:
                    return name
            pending += value.values()
        elif isinstance(value, list):
            pending += [each for each in value if isinstance(each, dict | list)]
    return ""


def start_of(command: str, options: Sequence[str], executor: Executor) -> Start:
    """Return how an executor starts the preprocessor; workers elsewhere find their own Python.

    Raises
    ------
    InputError
        No Python with FEniCSx on this machine, which is to compute.
    """
    python = find_interpreter() if isinstance(executor, Local) else ""
    refused = ["--no-scripts"] if are_refused() else []  # a specification may name one itself
    return Start(python, command, (*options, *refused))


def make_all(
    groups: Sequence[Sequence[Path]],
    start: Start,
    *,
    executor: Executor,
    done: Callable[[Path, Line], None],
    progress: Callable[[str], None],
) -> None:
    """Make the file of every specification.

    If a worker crashes, only its current file is lost.

    Parameters
    ----------
    groups : specification files, those of equal mesh together
    done : called with each specification and its outcome
    progress : called with the step that a worker of this machine begins

    Raises
    ------
    InputError : the preprocessor does not start.
    """
    with preprocessors(progress):
        distribute(executor, _Specifications(Work(groups), start, done))
