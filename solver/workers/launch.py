"""Start preprocessors in the Python with FEniCSx, and hand specifications out to them."""

import atexit
import contextlib
import json
import os
import platform
import subprocess
import tempfile
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NotRequired, TypedDict, cast

import plymotion

from ..errors import InputError
from ..inputs.common.mesh_files import are_refused, content_sha256
from ..package.common.files import remove_unfinished
from ..system.platform import end, link_or_copy, own_group
from .executors import Executor, Local, Task, distribute
from .interpreter import LAUNCHER, find_interpreter

# Start the preprocessor in the Python with FEniCSx and exchange lines of text with it.


class Line(TypedDict):
    """The outcome of a specification, a line of preprocess/products.py."""

    status: str  # built, unchanged, failed
    seconds: float
    text: str
    warnings: list[dict[str, str]]  # code, message
    error: str
    defect: str
    crashed: NotRequired[str]


# A worker is one process and starts no other ranks. Open MPI then needs neither its daemon nor
# networks; to start the one and look for the others takes it 0.4 s. Others ignore the variables.
ONE_RANK = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1"}

JOB = (("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"), ("PMI_RANK", "PMI_SIZE"))
EXPECTED_RANKS = "PLYMOTION_RANKS"  # read by preprocess/products.py


def mpi_job() -> tuple[int, int]:
    """Return rank and number of the processes that `mpirun` started; (0, 1) without it."""
    for rank, size in JOB:
        if os.environ.get(rank, "").isdecimal() and os.environ.get(size, "").isdecimal():
            return int(os.environ[rank]), int(os.environ[size])
    return 0, 1


def _of_job() -> tuple[int, ...]:
    """Files by which MPICH's processes talk to their launcher."""
    number = os.environ.get("PMI_FD", "")
    return (int(number),) if number.isdecimal() else ()


@contextmanager
def importable() -> Iterator[Path]:
    """A folder for PYTHONPATH that contains only `plymotion`.

    A checkout is such a folder. The folder of an installed package is not: its numpy is built
    for this Python. In this case, a folder with a link is created.
    """
    package = Path(plymotion.__file__).resolve().parent
    if (package.parent / "pyproject.toml").is_file():
        yield package.parent
        return
    with tempfile.TemporaryDirectory(prefix="plymotion-") as folder:
        link = Path(folder) / "plymotion"
        link_or_copy(package, link)
        yield Path(folder)


def environment(folder: Path, ranks: int = 1) -> dict[str, str]:
    """Return the environment for the other Python, without variables for modules of this one.

    Parameters
    ----------
    ranks : above 1: processes of this MPI job, each of which starts one that joins it
    """
    left_out = LAUNCHER if ranks == 1 else ()
    variables = {
        key: value
        for key, value in os.environ.items()
        if key not in ("PYTHONHOME", "VIRTUAL_ENV") and not key.startswith(left_out)
    }
    paths = [str(folder), *filter(None, [variables.get("PYTHONPATH")])]
    variables["PYTHONPATH"] = os.pathsep.join(paths)
    variables |= ONE_RANK if ranks == 1 else {EXPECTED_RANKS: str(ranks)}
    variables.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads do not help with small matrices
    return variables


def compile_forms() -> str:
    """Compile what DOLFINx needs of all sections, shells and solids; say what was done.

    Raises
    ------
    InputError : the compilation fails.
    """
    try:
        command = [find_interpreter(), "-P", "-m", "plymotion.preprocess", "compile"]
    except InputError:
        return "no Python with FEniCSx found: nothing is compiled for DOLFINx"
    with importable() as folder:
        done = subprocess.run(command, env=environment(folder), capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"compile: {done.stderr.strip()}")
    return done.stdout.strip()


@dataclass(frozen=True)
class Start:
    """How the preprocessor is started."""

    python: str  # empty: what each worker finds on its machine
    command: str
    options: tuple[str, ...]
    ranks: int = 1  # that share each analysis, one process of each


class Preprocessor:
    """A preprocessor process that makes one file after the other.

    Parameters
    ----------
    start : command of the preprocessor that reads names from standard input: body, section, ...
    """

    def __init__(self, start: Start) -> None:
        self.start, self.python = start, start.python or _found()
        # What specifications name may be relative to the current folder at the start. A fork of
        # this process must not use it.
        self.made_in = os.getcwd(), os.getpid()
        self._folder: Path | None = None  # of the file under way, or of the last one
        self.timer: threading.Timer | None = None  # ends it when it has had no work for a time
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  as long as the process
        # -P: modules of the current folder must not shadow installed ones. A new session:
        # Ctrl-C reaches only this process, which then ends the other.
        self._process = subprocess.Popen(
            [
                *(self.python, "-P", "-m", "plymotion.preprocess"),
                *(start.command, "-", "--json", *start.options),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=environment(_home(), start.ranks),
            pass_fds=_of_job() if start.ranks > 1 else (),
            text=True,
            encoding="utf-8",
            **own_group(),
        )

    def make(self, spec: Path, progress: Callable[[str], None]) -> Line | None:
        """Make one file and return the outcome; None if the process has ended before.

        Parameters
        ----------
        progress : called with each step
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._folder = spec.parent
        with contextlib.suppress(BrokenPipeError):  # it has ended, and says no more
            self._process.stdin.write(f"{spec}\n")
            self._process.stdin.flush()
        for text in self._process.stdout:
            line = json.loads(text)
            if "progress" not in line:
                return cast(Line, line)
            progress(line["progress"])
        return None

    def runs(self) -> bool:
        """Return whether the process has not ended."""
        return self._process.poll() is None

    def interrupt(self) -> None:
        """Interrupt the process; it removes its unfinished file."""
        end(self._process)

    def end(self, timeout: float) -> None:
        """Hand out no more queue, wait for the process for `timeout` [s], then kill it."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            end(self._process, at_once=True)  # and its compiler processes, if any
            self._process.wait()
        if self._folder is not None:  # a process that was killed has not cleaned up
            remove_unfinished(self._folder)

    def exit_code(self) -> int:
        """Exit code of the process; negative: ended by that signal."""
        return self._process.wait()

    def end_reason(self) -> str:
        """Reason of its end: exit code or signal, and the last lines of its standard error."""
        code = self.exit_code()
        self._errors.seek(0)
        text = self._errors.read().decode("utf-8", "replace").strip()
        text = text.replace("error: ", "")
        how = f"killed by signal {-code}" if code < 0 else f"ended with code {code}"
        return "\n".join([how, *text.splitlines()[-5:]])


# The task of a worker: have one file made by a preprocessor process of its own.

START_FAILED = 2  # exit code of a preprocessor that cannot start
IDLE_S = 60.0  # a preprocessor without work ends; a worker of dask may live for days
END_S = 10.0  # time for an idle process to end [s]
CLEANUP_S = 2.0  # time for an interrupted process to clean up [s]


_lock = threading.Lock()  # of the two lists
_idle: list[Preprocessor] = []
_busy: list[Preprocessor] = []
_listeners: list[Callable[[str], None]] = []
_kept = False


def keep_preprocessors() -> None:
    """Keep the preprocessors of this process for further files, `IDLE_S` long.

    A command ends them with its files. A Python program that changes and builds bodies again and
    again would load FEniCSx each time.
    """
    global _kept
    _kept = True


@contextmanager
def kept_preprocessors() -> Iterator[None]:
    """Keep the preprocessors of this process up to the end of a block.

    MPICH's launcher takes no output of a rank whose MPI has ended.
    """
    global _kept
    before, _kept = _kept, True
    try:
        yield
    finally:
        _kept = before
        if not _kept:  # else a block around this one keeps them
            _end_all(at_once=False)


def make(start: Start, spec: Path) -> Line:
    """Have the file of a specification made; return its outcome as in preprocess/products.py.

    A preprocessor that crashes makes this file fail, and the next one has another.

    Raises
    ------
    InputError
        No Python with FEniCSx, or the preprocessor does not start.
    """
    own = _taken(start)
    line = own.make(spec, _tell(spec))
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
    reason, code = own.end_reason(), own.exit_code()
    if code == START_FAILED:
        raise InputError(f"{own.python}: the preprocessor does not run: {reason}")
    return crashed(reason)


def _taken(start: Start) -> Preprocessor:
    """Return a preprocessor without work that was started in this way, or a new one."""
    with _lock:
        for own in _idle:
            same = (own.start, own.made_in) == (start, (os.getcwd(), os.getpid()))
            if same and own.runs():
                _idle.remove(own)
                _busy.append(own)
                assert own.timer is not None
                own.timer.cancel()
                return own
    own = Preprocessor(start)
    with _lock:
        _busy.append(own)
    return own


def _end_idle(own: Preprocessor) -> None:
    """End a preprocessor that has had no work."""
    with _lock:
        if own not in _idle:
            return
        _idle.remove(own)
    own.end(END_S)


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
        servers = [own for own in (*_idle, *_busy) if own.made_in[1] == os.getpid()]
        _idle.clear()
        _busy.clear()
    for own in servers if at_once else ():
        own.interrupt()
    for own in servers:
        if own.timer is not None:
            own.timer.cancel()
        own.end(CLEANUP_S if at_once else END_S)


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


# Specifications of a batch, handed out to an executor: each mesh to one worker if possible.

MOST_CRASHES = 3  # number of crashes without a result in between after which the batch is aborted


class SpecificationQueue:
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
    """The source of an executor (executors.py)."""

    def __init__(
        self, queue: SpecificationQueue, start: Start, done: Callable[[Path, Line], None]
    ) -> None:
        self._queue, self._start, self._done = queue, start, done
        self._crashes = 0

    def next(self, lane: int, width: int) -> Task | None:
        """Return the next specification for a lane."""
        spec = self._queue.next(lane)
        if spec is None:
            return None
        # The file is written beside the name, not beside what a link of this name leads to.
        return Task(make, (self._start, spec.parent.resolve() / spec.name), spec)

    def took(self, task: Task, result: Any) -> None:
        """Report an outcome. Raises InputError: the preprocessor crashes all the time."""
        if result["status"] == "built" and (changed := _changed_mesh(task.content)):
            # Nobody knows which content was read: the file would be taken for that of the first.
            task.content.with_suffix(".vtkhdf").unlink(missing_ok=True)
            message = (
                f"{changed}: was changed while it was analysed; the same command does it again"
            )
            result = result | {"status": "failed", "error": message}
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
            if isinstance(name, str) and isinstance(digest, str):
                file = Path(name)
                if not file.is_file() or content_sha256(file) != digest:
                    return name
            pending += value.values()
        elif isinstance(value, list):
            pending += [each for each in value if isinstance(each, dict | list)]
    return ""


def start_of(command: str, options: Sequence[str], executor: Executor, ranks: int = 1) -> Start:
    """Return how an executor starts the preprocessor; workers elsewhere find their own Python.

    Parameters
    ----------
    command : name of the preprocessor
    options : its options
    executor : where it runs
    ranks : number of MPI ranks of a task

    Raises
    ------
    InputError
        No Python with FEniCSx on this machine, which is to compute.
    """
    python = find_interpreter() if isinstance(executor, Local) else ""
    refused = ["--no-scripts"] if are_refused() else []  # a specification may name one itself
    return Start(python, command, (*options, *refused), ranks)


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
        distribute(executor, _Specifications(SpecificationQueue(groups), start, done))
