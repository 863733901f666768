"""Results so far of runs under way: how a report asks for them, and how a run answers.

The report asks by a file in build/CASE/live. The process of a run looks for it between steps and
makes a copy of itself (fork). The copy ends the run at the present time, writes its results to
build/CASE/live/RUN and exits; the run itself goes on at once.
"""

import contextlib
import os
import signal
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

from ..math.rows import reopen_stored
from ..system.interrupts import ignore
from ..system.platform import can_fork
from .codes import UNDER_WAY

FOLDER, REQUEST = "live", "request"
LOOK_S = 0.5  # between two looks for a request; a look takes 2e-6 s
FRESH_S = 10.0  # age after which a request is ignored
SHARE = 2.0  # pause after a copy, over the time that it took: copies have a third of a core at most


def ask(case_dir: Path) -> None:
    """Ask the runs of a case for their results so far, for the next FRESH_S."""
    (case_dir / FOLDER / REQUEST).write_text(f"{time.time():.3f}\n", encoding="utf-8")


def answers(case_dir: Path, since: float) -> dict[str, float]:
    """Return the runs that have answered since a time [s], with the times of their answers."""
    times = {}
    for file in (case_dir / FOLDER).glob("*/summary.json"):
        with contextlib.suppress(OSError):  # it may just be replaced
            written = file.stat().st_mtime
            done = case_dir / file.parent.name / file.name
            if written >= since and not (done.is_file() and done.stat().st_mtime > written):
                times[file.parent.name] = written
    return times


class Copies:
    """Copies of the process of a run that write its results so far.

    Parameters
    ----------
    out : folder of the results of the run, build/CASE/RUN
    """

    def __init__(self, out: Path) -> None:
        self.out = out  # of this process: in a copy, build/CASE/live/RUN
        self.is_copy = False
        self._request = out.parent / FOLDER / REQUEST
        self._child, self._begin, self._next = 0, 0.0, 0.0

    def code(self) -> str:
        """Return the code by which this process is to end the run; "" in the run itself."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + LOOK_S
            if not self._busy(now) and self._asked() and can_fork():
                self._make(now)
        return UNDER_WAY.name if self.is_copy else ""

    def _asked(self) -> bool:
        try:
            return time.time() - self._request.stat().st_mtime < FRESH_S
        except OSError:
            return False

    def _busy(self, now: float) -> bool:
        """Return whether the last copy is at work; once it is not, pause for SHARE of its time."""
        if not self._child:
            return False
        if os.waitpid(self._child, os.WNOHANG) == (0, 0):
            return True
        self._child, self._next = 0, now + SHARE * (now - self._begin)
        return True

    def _make(self, now: float) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # threads: they only wait
            self._child, self._begin = os.fork(), now
        if not self._child:
            self.is_copy, self.out = True, self._request.parent / self.out.name
            ignore()
            reopen_stored()

    @contextlib.contextmanager
    def ending(self) -> Iterator[None]:
        """End a copy with the block, whatever happens in it; a run ends its last copy first."""
        try:
            yield
        finally:
            if self.is_copy:
                os._exit(0)
            if self._child:  # neither Ctrl-C nor the results wait for it
                os.kill(self._child, signal.SIGKILL)
                os.waitpid(self._child, 0)
