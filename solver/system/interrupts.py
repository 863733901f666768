"""Signals that end a command: Ctrl-C, TERM of a batch scheduler, HUP of a lost connection.

All three raise KeyboardInterrupt, so that what is computed is kept in the same way.
"""

import _thread
import contextlib
import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import CodeType, FrameType
from typing import Any, TypeVar

from .platform import ENDING, POSIX, alarm, blocked, pass_on

Handler = Callable[[int, FrameType | None], None]
Function = TypeVar("Function", bound=Callable[..., Any])

INTERRUPTED = 130  # exit code of a program that was ended by Ctrl-C

COMPLETING = b"interrupted: completing the files, %.1f CPU s at most; again: without them\n"
SAME_S = 0.3  # a worker receives a signal to the group twice: by itself, and from its parent

_received: list[int] = []  # since the command began
_commands = 0  # that are under way in this process
_written: dict[str, None] = {}  # files that this process has completed


@contextlib.contextmanager
def handled_signals() -> Iterator[None]:
    """Treat TERM and HUP like Ctrl-C as long as a command is under way.

    A signal that is ignored stays so (`nohup`). Does nothing outside the main thread.
    """
    global _commands
    if not _commands:
        _received.clear()
        _written.clear()
    _commands += 1
    try:
        with _handled(_interrupt), _not_lost():
            yield
    finally:
        _commands -= 1


@contextlib.contextmanager
def _not_lost() -> Iterator[None]:
    """Send a signal again that came where Python drops exceptions.

    In a finalizer, a callback of a weak reference (each import has one) or one of a C library
    Python would print the traceback of the KeyboardInterrupt and go on.
    """
    before = sys.unraisablehook

    @uninterrupted
    def hook(dropped: "sys.UnraisableHookArgs") -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt) and _received:
            # Not threading.Thread: the finalizer may run where that holds its lock.
            _thread.start_new_thread(_send_again, (_received[-1],))
            _received.clear()  # where only the first counts, this one has not
        else:
            before(dropped)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _send_again(number: int) -> None:
    time.sleep(0.001)  # the finalizer has returned, or an uninterrupted function
    if sys.platform == "win32":
        signal.raise_signal(number)
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, number)


_whole: set[CodeType] = set()  # functions that end before a signal counts


def uninterrupted(function: Function) -> Function:
    """Let a function end before a signal counts: HDF5 may crash where an exception ends a call."""
    _whole.add(function.__code__)
    return function


def _waiting(handler: Handler) -> Handler:
    """Return a handler that waits for the end of uninterrupted functions."""

    def outside(number: int, frame: FrameType | None) -> None:
        place = frame
        while place is not None and place.f_code not in _whole:
            place = place.f_back
        if place is None:
            handler(number, frame)
        else:
            _thread.start_new_thread(_send_again, (number,))

    return outside


def note_complete(file: str) -> None:
    """Note a file that is complete under its name."""
    _written[file] = None


def ending_words() -> str:
    """Return what an interrupted command says of its files."""
    last = next((file for file in reversed(_written) if os.path.exists(file)), None)
    if last is not None:  # those of temporary folders are gone
        return f"interrupted: complete files are kept, the last is {last}"
    return "interrupted: nothing written"


def begin_program() -> None:
    """End the program at a signal while it starts, and keep NumPy, not yet imported, to one thread.

    An exception within an import would be a traceback, or be taken for a missing module.
    More threads cost 0.1 s and do not help with small matrices. Workers inherit the setting.
    Looking for garbage so seldom saves 0.04 s while modules are imported.
    """
    gc.set_threshold(200_000)
    if "OMP_NUM_THREADS" not in os.environ:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    handle(_end)


@contextlib.contextmanager
def starting() -> Iterator[None]:
    """Do what `begin_program` says while modules of a command are imported."""
    with _handled(_end) if _commands else contextlib.nullcontext():
        yield


@contextlib.contextmanager
def deferred() -> Iterator[None]:
    """Complete a block before a signal counts: a library that is half imported is called missing.

    Extensions in C turn the KeyboardInterrupt of an import within their own into an ImportError.
    """
    received: list[int] = []
    try:
        with _handled(lambda number, _: received.append(number)):
            yield
    finally:
        if received:
            signal.raise_signal(received[0])


def _end(number: int, frame: FrameType | None) -> None:
    os.write(2, f"{ending_words()}\n".encode(errors="backslashreplace"))
    os._exit(128 + number)


@contextlib.contextmanager
def completing(patience_s: float | None = None) -> Iterator[None]:
    """Complete a block that saves results before a signal counts; a second one counts at once.

    In a command the signal is noted, see `stop_requested`; elsewhere it is raised after the block.
    With `patience_s`, a block that takes more CPU time after the signal, or after its begin if the
    signal came before, ends with KeyboardInterrupt: a busy machine does not lose what is computed.
    So does one that takes ten times as long by the clock.
    Without timers of POSIX a signal ends it at once.
    """
    received: list[float] = []  # when it came

    def delay(number: int, frame: FrameType | None) -> None:
        note(number)
        now = time.monotonic()
        if not received:
            received.append(now)
            if patience_s is not None and _commands:
                os.write(2, COMPLETING % patience_s)
            limit()
        elif now - received[0] > SAME_S:
            raise KeyboardInterrupt

    def limit() -> None:
        if patience_s is None or stops:
            return
        # Repeated: Python drops an exception within a finalizer.
        stop = alarm(patience_s, _waiting(expired))
        if stop is None:
            raise KeyboardInterrupt
        stops.append(stop)

    def expired(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    stops: list[Callable[[], None]] = []
    main = threading.current_thread() is threading.main_thread()
    try:
        with _handled(delay):
            if stop_requested() and main and POSIX:
                limit()
            yield
    finally:
        for end_of_alarm in stops:
            end_of_alarm()
    if received and not _commands:
        raise KeyboardInterrupt


def stop_requested() -> bool:
    """Return whether a signal has asked the command to end."""
    return bool(_received)


def exit_code(code: int) -> int:
    """Return 128 + the signal for a command that a signal has ended, `code` for others.

    CPython ends by SIGINT, whatever the exit code, if a KeyboardInterrupt has left code that was
    given to `exec` as text (dataclasses and named tuples are made so), even if it was caught later.
    The next such code clears that.
    """
    if code == INTERRUPTED:
        exec("")
    return 128 + _received[0] if code == INTERRUPTED and _received else code


def of_a_signal(error: BaseException) -> bool:
    """Return whether an exception was made of a KeyboardInterrupt.

    Python 3.11 turns one that comes while a class is made into a RuntimeError, extensions in C one
    that comes while a module is imported into an ImportError, Pydantic into a SchemaError; without
    a trace of it. After a signal, therefore, each is taken for one.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__ or cause.__context__
    return stop_requested() or cause is not None


def passed_to_children(stop: Any, processes: Callable[[], list[int]]) -> Any:
    """Return a context in which a signal sets the event `stop` and goes to child processes."""
    parent = os.getpid()

    def forward(number: int, frame: FrameType | None) -> None:
        note(number)
        stop.set()
        pass_on(number, processes() if os.getpid() == parent else ())

    return _handled(forward)


def ignore() -> None:
    """Leave all signals to the parent process, which ends this one; or to nobody, at the end."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)


@contextlib.contextmanager
def shielded() -> Iterator[None]:
    """Start processes that call `ignore`; before that call, too, no signal reaches them.

    A signal to this process counts after the block.
    """
    with deferred(), blocked():
        yield


def handle(handler: Handler) -> None:
    """Set the handler of a process for all signals that are not ignored."""
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _waiting(handler))


@contextlib.contextmanager
def _handled(handler: Handler) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in ENDING}
    handle(handler)
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


def _interrupt(number: int, frame: FrameType | None) -> None:
    note(number)
    raise KeyboardInterrupt


def note(number: int) -> None:
    """Note a signal that a handler turns into KeyboardInterrupt."""
    _received.append(number)
