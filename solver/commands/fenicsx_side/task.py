"""The task of a worker: have one file made by a preprocessor process of its own."""

import atexit
import contextlib
import os
import platform
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
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
class _Started:
    """A preprocessor process; it ends when it has had no work for a time."""

    start: Start
    python: str
    folder: str  # the current one at its start: what specifications name may be relative to it
    process: Preprocessor
    owner: int  # process that started it; a fork of it must not use it
    timer: threading.Timer | None = None


_lock = threading.Lock()  # of the two lists
_idle: list[_Started] = []
_busy: list[_Started] = []
_listeners: list[Callable[[str], None]] = []
_kept = False


def keep_preprocessors() -> None:
    """Keep the preprocessors of this process for further files, `IDLE_S` long.

    A command ends them with its files. A Python program that changes and builds bodies again and
    again would load FEniCSx each time.
    """
    global _kept
    _kept = True


def make(start: Start, spec: Path) -> Line:
    """Have the file of a specification made; return its outcome as in preprocess/batch.py.

    A preprocessor that crashes makes this file fail, and the next one has another.

    Raises
    ------
    InputError
        No Python with FEniCSx, or the preprocessor does not start.
    """
    own = _taken(start)
    line = own.process.make(spec, _tell(spec))
    with _lock:
        ended = own not in _busy
        if not ended:
            _busy.remove(own)
        if line is not None and not ended:
            own.timer = threading.Timer(IDLE_S, _end_idle, (own,))
            own.timer.daemon = True
            own.timer.start()
            _idle.append(own)
    if line is not None:
        return line
    reason, code = own.process.end_reason(), own.process.exit_code()
    if code == START_FAILED:
        raise InputError(f"{own.python}: the preprocessor does not run: {reason}")
    return crashed(reason)


def _taken(start: Start) -> _Started:
    """Return a preprocessor without work that was started in this way, or a new one."""
    folder = os.getcwd()
    with _lock:
        for own in _idle:
            same = (own.start, own.folder, own.owner) == (start, folder, os.getpid())
            if same and own.process.runs():
                _idle.remove(own)
                _busy.append(own)
                assert own.timer is not None
                own.timer.cancel()
                return own
    python = start.python or _found()
    process = Preprocessor(python, _home(), start.command, start.options)
    own = _Started(start, python, folder, process, os.getpid())
    with _lock:
        _busy.append(own)
    return own


def _end_idle(own: _Started) -> None:
    """End a preprocessor that has had no work."""
    with _lock:
        if own not in _idle:
            return
        _idle.remove(own)
    own.process.end(END_S)


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
    finished = False
    try:
        yield
        finished = True
    finally:
        _listeners.remove(progress)
        if not (finished and _kept):
            _end_all(at_once=not finished)


def _end_all(*, at_once: bool) -> None:
    """End the preprocessors that this process has started."""
    with _lock:
        found = [own for own in (*_idle, *_busy) if own.owner == os.getpid()]
        _idle.clear()
        _busy.clear()
    if at_once:
        for own in found:
            own.process.interrupt()
    for own in found:
        if own.timer is not None:
            own.timer.cancel()
        own.process.end(CLEANUP_S if at_once else END_S)


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
