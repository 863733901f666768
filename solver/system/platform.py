"""What POSIX has and other systems lack, each with a fallback (docs/platforms.md).

PLYMOTION_NO_FORK=1 takes the fallbacks on POSIX as well: no forks, groups of processes, masks and
timers of signals, locks, or links.
"""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # all commands import this module: 0.02 s of `--help`
    import subprocess
    from concurrent.futures import ProcessPoolExecutor

POSIX: bool = os.name == "posix" and os.environ.get("PLYMOTION_NO_FORK", "0") in ("", "0")

# Signals that end a command.
ENDING = [signal.SIGINT, signal.SIGTERM]
if sys.platform != "win32" and POSIX:
    ENDING.append(signal.SIGHUP)


def cores() -> int:
    """Return the number of cores that this process may use.

    `PYTHON_CPU_COUNT` says it, which Python knows itself from 3.13 on.
    """
    asked = os.environ.get("PYTHON_CPU_COUNT", "")
    if asked.isdecimal() and int(asked):
        return int(asked)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def host() -> str:
    """Return the name of this machine; the module `socket` takes 5 ms to import."""
    return os.uname().nodename if hasattr(os, "uname") else os.environ.get("COMPUTERNAME", "")


# Processes.


def can_fork() -> bool:
    """Return whether this process can be copied where that is safe (Linux)."""
    return POSIX and sys.platform == "linux"


def context(*, fresh: bool = False) -> Any:
    """Return how `multiprocessing` starts processes.

    Parameters
    ----------
    fresh : as new interpreters; otherwise as copies of this process where that is safe (Linux),
        which have its modules and data already
    """
    from multiprocessing import get_context

    return get_context("fork" if can_fork() and not fresh else "spawn")


def processes(
    count: int, begin: Callable[..., None] | None = None, *arguments: Any, fresh: bool = False
) -> "ProcessPoolExecutor":
    """Return a pool of processes, each of which calls `begin(*arguments)` first.

    Parameters
    ----------
    count : number of processes
    begin : function that each process calls first
    arguments : its arguments
    fresh : start new interpreters in place of forks
    """
    from concurrent.futures import ProcessPoolExecutor

    return ProcessPoolExecutor(count, context(fresh=fresh), begin, arguments)


def end_with_parent() -> None:
    """End this process of `processes` when the one that started it has ended, however that ends."""
    from multiprocessing import parent_process
    from threading import Thread

    def wait() -> None:
        parent = parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    Thread(target=wait, daemon=True).start()


def own_group() -> dict[str, Any]:
    """Return the arguments of Popen by which Ctrl-C of the terminal spares a program."""
    if POSIX:
        return {"start_new_session": True}
    import subprocess

    return {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}


def end(process: "subprocess.Popen[Any]", *, at_once: bool = False) -> None:
    """Interrupt a program with `own_group`, or kill it at once, and the programs that it started.

    Without groups of POSIX: the program alone, which is ended by either.
    """
    with contextlib.suppress(OSError):  # it has ended in the meantime
        if sys.platform != "win32" and POSIX:
            os.killpg(process.pid, signal.SIGKILL if at_once else signal.SIGINT)
        elif at_once:
            process.kill()
        else:
            process.terminate()


def pass_on(number: int, children: Iterable[int]) -> None:
    """Send a signal to child processes; elsewhere than on POSIX the terminal has done so."""
    for child in children if POSIX else ():
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, number)


def has_ended(process: int) -> bool:
    """Return whether a process is no more; False if that cannot be found out.

    One that has ended may still wait for its parent (Linux). On Windows `os.kill` ends a process,
    whatever the signal.
    """
    if not POSIX:
        return False
    try:
        os.kill(process, 0)
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except ProcessLookupError:
        return True
    except (OSError, IndexError):
        return False
    return state in ("Z", "X")


# Signals.


@contextlib.contextmanager
def blocked() -> Iterator[None]:
    """Start processes in a block that hear no signal from their first instruction on.

    Without masks of POSIX they hear them until they ignore them.
    """
    if sys.platform == "win32" or not POSIX:
        yield
        return
    from multiprocessing import resource_tracker

    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        resource_tracker.ensure_running()  # a process too; its start unblocks some
        signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


STALLED = 10.0  # time by the clock over CPU time: the load of a busy machine is below it


def alarm(seconds: float, handler: Callable[..., None]) -> Callable[[], None] | None:
    """Call a handler after some CPU time of the process, again and again; return what stops that.

    Also after ten times as long by the clock: a disk that does not answer takes no CPU time. None
    without timers of POSIX.
    """
    if sys.platform == "win32" or not POSIX:
        return None
    before = [signal.signal(number, handler) for number in (signal.SIGPROF, signal.SIGALRM)]
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.1)
    signal.setitimer(signal.ITIMER_REAL, STALLED * seconds, 0.1)

    def stop() -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in zip((signal.SIGPROF, signal.SIGALRM), before, strict=True):
            signal.signal(number, handler)

    return stop


@contextlib.contextmanager
def limited(seconds: float, message: str) -> Iterator[None]:
    """End a block that takes more CPU time by TimeoutError, in a main thread where POSIX is."""

    def expired(*_: Any) -> None:
        raise TimeoutError(message)

    main = threading.current_thread() is threading.main_thread()
    stop = alarm(seconds, expired) if main else None
    try:
        yield
    finally:
        if stop:
            stop()


# Files.


def locked(descriptor: int, *, shared: bool = False, wait: bool = False) -> bool:
    """Lock an open file or folder; False if another process has it, and `wait` is not given.

    The end of the process, however it ends, unlocks it.

    Parameters
    ----------
    descriptor : open file or folder
    shared : lock for reading
    wait : wait for other processes

    Raises
    ------
    OSError
        The system or this file system has no such locks.
    """
    if sys.platform == "win32" or not POSIX:
        raise OSError("no locks of POSIX")
    import fcntl

    how = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    try:
        fcntl.flock(descriptor, how if wait else how | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def link_or_copy(source: Path, target: Path) -> None:
    """Make a link to a folder, or a copy where there is no permission to create links."""
    try:
        if not POSIX:
            raise OSError("no links")
        target.symlink_to(source, target_is_directory=True)
    except OSError:
        import shutil

        shutil.copytree(source, target)
