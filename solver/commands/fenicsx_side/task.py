"""The task of a worker: have one file made by a preprocessor process of its own."""

import atexit
import contextlib
import platform
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from ...errors import InputError
from .interpreter import find_interpreter
from .launch import Line, Preprocessor, importable

START_FAILED = 2  # exit code of a preprocessor that cannot start
IDLE_S = 60.0  # a preprocessor without work ends; a worker of dask may live for days
END_S = 10.0  # time for an idle process to end [s]
CLEANUP_S = 2.0  # time for an interrupted process to clean up [s]


@dataclass(frozen=True)
class Start:
    """How the preprocessor is started."""

    python: str  # empty: what each worker finds on its machine
    command: str
    options: tuple[str, ...]


@dataclass(eq=False)
class _Own:
    """The preprocessor of a thread."""

    lock: threading.Lock = field(default_factory=threading.Lock)
    start: Start | None = None
    process: Preprocessor | None = None
    timer: threading.Timer | None = None

    def end(self, timeout: float) -> None:
        """End the process, if there is one."""
        if self.timer is not None:
            self.timer.cancel()
        with self.lock:
            if self.process is not None:
                self.process.end(timeout)
            self.process = None


_threads = threading.local()
_all: set[_Own] = set()  # of this process
_listeners: list[Callable[[str], None]] = []


def make(start: Start, spec: Path) -> Line:
    """Have the file of a specification made; return its outcome as in preprocess/batch.py.

    A preprocessor that crashes makes this file fail, and the next one has another.

    Raises
    ------
    InputError
        No Python with FEniCSx, or the preprocessor does not start.
    """
    if not hasattr(_threads, "own"):
        _threads.own = _Own()
    own: _Own = _threads.own
    _all.add(own)
    if own.timer is not None:
        own.timer.cancel()
    if own.start != start:
        own.end(END_S)
    with own.lock:
        if own.process is None:
            python = start.python or _found()
            own.process = Preprocessor(python, _home(), start.command, start.options)
            own.start = start
        line = own.process.make(spec, _tell(spec))
        if line is None:
            reason, code = own.process.end_reason(), own.process.exit_code()
            own.process = None
            if code == START_FAILED:
                raise InputError(f"{start.python}: the preprocessor does not run: {reason}")
            return crashed(reason)
    own.timer = threading.Timer(IDLE_S, own.end, (END_S,))
    own.timer.daemon = True
    own.timer.start()
    return line


def crashed(reason: str) -> Line:
    """Return the outcome of a file whose preprocessor has ended."""
    return {
        "status": "failed",
        "seconds": 0.0,
        "text": "",
        "warnings": [],
        "error": f"the preprocessor ended unexpectedly: {reason}",
        "defect": "",
        "crashed": reason,
    }


@contextlib.contextmanager
def preprocessors(progress: Callable[[str], None]) -> Iterator[None]:
    """End the preprocessors of this process after a block: at once if it was interrupted.

    Parameters
    ----------
    progress : called with what they begin; those of other processes do not call it
    """
    _listeners.append(progress)
    timeout = CLEANUP_S
    try:
        yield
        timeout = END_S
    finally:
        _listeners.remove(progress)
        found = [own.process for own in _all if own.process is not None]
        if timeout == CLEANUP_S:
            for process in found:
                process.interrupt()
        for process in found:
            process.end(timeout)
        for own in list(_all):  # threads that waited for a process have gone on by now
            own.end(timeout)
            _all.discard(own)


def _tell(spec: Path) -> Callable[[str], None]:
    def progress(step: str) -> None:
        for listener in _listeners:
            listener(f"{spec.stem}: {step}")

    return progress


@cache
def _found() -> str:
    try:
        return find_interpreter()
    except InputError as error:
        raise InputError(f"{platform.node()}: {error}") from error


@cache
def _home() -> Path:
    """Return the folder with `plymotion`, which is there as long as this process."""
    stack = ExitStack()
    atexit.register(stack.close)
    return stack.enter_context(importable())
