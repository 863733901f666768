"""Run programs side by side on a number of cores, each with its output in one piece."""

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import IO

POLL = 0.05  # s between two looks at the programs that run


@dataclass(frozen=True)
class Job:
    """A program to run.

    Attributes
    ----------
    title : its name in messages
    command : program and arguments
    cores : how many cores it uses, more than there are if it runs alone. Those with 0 run beside
        others, one after the other
    environment : variables that differ from those of this process
    after : another job of the same call, which must have ended before
    """

    title: str
    command: tuple[str, ...]
    cores: int = 1
    environment: Mapping[str, str] = field(default_factory=dict)
    after: "Job | None" = None


@dataclass(frozen=True)
class Done:
    """What came of a job: exit code (127: it did not start), wall time [s] and all it wrote.

    `cpu` is the time [s] of its processes on the cores; 0 for those that were interrupted.
    """

    job: Job
    code: int
    seconds: float
    output: str
    cpu: float = 0.0


@dataclass
class _Running:
    job: Job
    process: subprocess.Popen[bytes]
    file: IO[bytes]
    start: float
    told: int = 0  # bytes of the file that lines() has returned
    cpu: float = 0.0

    def ended(self) -> bool:
        """True if the process has ended."""
        if self.process.returncode is None:
            found, status, usage = os.wait4(self.process.pid, os.WNOHANG)
            if found:
                self.process.returncode = os.waitstatus_to_exitcode(status)
                self.cpu = usage.ru_utime + usage.ru_stime
        return self.process.returncode is not None

    def lines(self) -> list[str]:
        """The lines that were completed since the last call."""
        # The process writes at the position of this file: it must not be moved.
        size = os.fstat(self.file.fileno()).st_size - self.told
        new = os.pread(self.file.fileno(), size, self.told) if size else b""
        complete = new[: new.rfind(b"\n") + 1]
        self.told += len(complete)
        return complete.decode("utf-8", "replace").splitlines()

    def done(self) -> Done:
        self.file.seek(0)
        text = self.file.read().decode("utf-8", "replace")
        self.file.close()
        code = self.process.returncode
        return Done(self.job, code, time.monotonic() - self.start, text, self.cpu)


def run_all(
    jobs: Iterable[Job],
    cores: int,
    *,
    started: Callable[[Job], object] = lambda job: None,
    ended: Callable[[Done], object] = lambda done: None,
    wrote: Callable[[Job, str], object] | None = None,
    patience: float = 10.0,
) -> list[Done]:
    """Run jobs, the first ones first, as many at once as fit on the cores.

    Returns the results in the order of the jobs, each of which must come behind the one it waits
    for. `wrote` is called with each line of output as soon as it is complete, at the latest before
    `ended`. Ctrl-C, SIGTERM and SIGHUP end all jobs; `ended` is called with what they wrote so far,
    then KeyboardInterrupt is raised. Those that go on for `patience` [s] after SIGINT are killed;
    a job that itself runs jobs must have less patience.
    """
    order = list(jobs)
    waiting = list(order)
    running: list[_Running] = []
    results: dict[int, Done] = {}
    old = {number: signal.signal(number, _interrupt) for number in _SIGNALS}
    try:
        while waiting or running:
            for job in list(waiting):
                ready = job.after is None or id(job.after) in results
                if ready and _fits(job, [one.job for one in running], cores):
                    waiting.remove(job)
                    started(job)
                    each = _start(job)
                    if isinstance(each, Done):
                        results[id(job)] = each
                        ended(each)
                    else:
                        running.append(each)
            finished = [one for one in running if one.ended()]
            if wrote is not None:
                for one in running:
                    for line in one.lines():
                        wrote(one.job, line)
            for one in finished:
                running.remove(one)
                results[id(one.job)] = done = one.done()
                ended(done)
            if running:
                time.sleep(POLL)
    except KeyboardInterrupt:
        _stop(running, patience)
        for one in running:
            ended(one.done())
        raise
    finally:
        for number, handler in old.items():
            signal.signal(number, handler)
    return [results[id(job)] for job in order]


def _fits(job: Job, running: list[Job], cores: int) -> bool:
    """True if there is room beside the jobs that run."""
    if job.cores > cores or any(one.cores > cores for one in running):
        return not running
    if job.cores == 0:
        return all(one.cores for one in running)
    return job.cores <= cores - sum(one.cores for one in running)


_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def _interrupt(number: int, frame: object) -> None:
    raise KeyboardInterrupt


def _start(job: Job) -> _Running | Done:
    """Start a job in a session of its own, so that one signal reaches all its processes.

    Other file descriptors stay open: through them the parts of one `make` share its job slots.
    A handler of SIGINT is set here, so a child does not inherit that SIGINT is ignored, as it is
    in a command that a shell runs in the background.
    """
    file = tempfile.TemporaryFile()  # noqa: SIM115  _Running.done closes it
    try:
        process = subprocess.Popen(
            job.command,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            env={**os.environ, **job.environment},
            close_fds=False,
            start_new_session=True,
        )
    except OSError as error:
        file.close()
        return Done(job, 127, 0.0, f"{job.command[0]}: {error.strerror}\n")
    return _Running(job, process, file, time.monotonic())


def _stop(running: list[_Running], patience: float) -> None:
    """End all processes of the jobs: SIGINT, and SIGKILL for those that go on."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)  # it takes `patience` at most
    end = time.monotonic() + patience
    for number in (signal.SIGINT, signal.SIGKILL):
        for each in running:
            try:
                os.killpg(each.process.pid, number)
            except ProcessLookupError:
                continue  # all its processes have ended
        for each in running:
            try:
                each.process.wait(max(0.0, end - time.monotonic()))
            except subprocess.TimeoutExpired:
                continue
    for each in running:
        each.process.wait()
