"""Where the CPU time of a run goes."""

import logging
import time
from collections.abc import Mapping

from ..math.compiled import statistics
from ..system.interrupts import stop_requested

# import: the program itself; load: run file, packages, compiled functions; build: model, start,
# signals; integrate: steps; monitors: checks after steps; recover: signals and checks of the
# solution; write: result.vtkhdf.
LOGGER = logging.getLogger(__name__)
PHASES = ("import", "load", "build", "integrate", "monitors", "recover", "write")
PACE = 0.1  # part of the patience in which a stage shows its pace, by some blocks of rows
FIRST_LINE_S = 2.0  # wall time after which a run without a terminal shows where it is


def work_s() -> float:
    """Return the CPU seconds of this process, without those of loading compiled functions.

    These are compiled once for each release: planning with a budget must not pay for that.
    """
    return time.process_time() - statistics.load_s


class StageProgress:
    """Show how far a stage is: a line on standard error after 2 s, then at doubled intervals.

    Parameters
    ----------
    patience_s : CPU time for the rest of the stage after a signal; a stage whose pace needs more
        ends with KeyboardInterrupt
    """

    def __init__(
        self, label: str, stage: str, *, show: bool, patience_s: float = float("inf")
    ) -> None:
        self._words, self._patience_s = f"{label}: {stage}", patience_s
        self._begin, self._next = time.perf_counter(), FIRST_LINE_S if show else float("inf")
        self._begin_cpu = time.process_time()

    def __call__(self, part: float) -> None:
        """Note the part that is done."""
        seconds = time.perf_counter() - self._begin
        taken = time.process_time() - self._begin_cpu
        late = taken > PACE * self._patience_s and taken * (1.0 - part) > self._patience_s * part
        if late and stop_requested():
            raise KeyboardInterrupt
        if seconds > self._next:
            self._next = 2.0 * seconds
            LOGGER.info("%s: %.0f %%, %.0f s", self._words, 100.0 * part, seconds)


class Stopwatch:
    """CPU seconds of this process by phase."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PHASES, 0.0)
        self._last, self._loaded = time.process_time(), statistics.load_s

    def lap(self, phase: str) -> None:
        """Add the time since the last call to a phase; that of compiled functions is loading."""
        now, loaded = time.process_time(), statistics.load_s
        loading = loaded - self._loaded
        self.seconds["load"] += loading
        self.seconds[phase] += max(now - self._last - loading, 0.0)
        self._last, self._loaded = now, loaded

    def skip(self) -> None:
        """Leave out the time since the last call."""
        self._last, self._loaded = time.process_time(), statistics.load_s

    def move(self, seconds: float, source: str, target: str) -> None:
        """Count time of one phase as that of another.

        Parameters
        ----------
        seconds : CPU time [s]
        source : phase from which it is taken
        target : phase to which it is added
        """
        moved = min(seconds, self.seconds[source])
        self.seconds[source] -= moved
        self.seconds[target] += moved


def timing_text(seconds: Mapping[str, float]) -> str:
    """Return one line: all phases and their sum."""
    parts = [f"{phase} {value:.3f}" for phase, value in seconds.items()]
    return f"CPU seconds: {', '.join(parts)}; sum {sum(seconds.values()):.3f}"
