"""How long the attack is, and what it counts: quick, or long with PLYMOTION_ATTACK."""

import json
import os
import signal
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

# A file for the counts: set, the attack is long (`make attack`).
RECORD = os.environ.get("PLYMOTION_ATTACK", "")
LONG = 2 if RECORD else 1
# What may become of a try. Those of BAD fail the test as well.
GOOD = ("done", "refused", "recovered")
BAD = ("traceback", "hang", "silent change", "file lost", "command run", "other")
MISSED = "not hit"  # the fault came when the command had done its work: no try
LIMIT_S = 60.0  # CPU time of a try after which it hangs
WAIT_S = 1800.0  # wall time of a process: `make attack` may share a busy machine
OUTCOME = "outcome of the test"  # instead of a kind of try


def tries(quick: int, long: int) -> int:
    """Number of tries of a test."""
    return long if RECORD else quick


def count(kind: str, end: str) -> None:
    """Count a try of a kind by its end; kept with PLYMOTION_ATTACK only."""
    assert end in (*GOOD, *BAD, MISSED)
    test = os.environ["PYTEST_CURRENT_TEST"].rpartition(" ")[0]
    _append(test, kind, end)


def note_outcome(test: str, outcome: str) -> None:
    """Note that a test is over: the same attack does not repeat it."""
    _append(test, OUTCOME, outcome)


def _append(*words: str) -> None:
    if RECORD:
        with Path(RECORD).open("a", encoding="utf-8") as file:
            file.write(json.dumps(words) + "\n")


def recorded(file: Path) -> tuple[dict[str, str], Counter[tuple[str, str]]]:
    """Return the outcomes of tests, and tries by kind and end of those that are over.

    Tries of a test that was interrupted are left out; it is begun again.
    """
    ends: dict[str, str] = {}
    tried: dict[str, Counter[tuple[str, str]]] = {}
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else []:
        try:
            test, kind, end = json.loads(line)
        except ValueError:  # cut off
            continue
        if kind == OUTCOME:
            ends[test] = end
            if end == "begun":
                tried[test] = Counter()
        else:
            tried.setdefault(test, Counter())[kind, end] += 1
    over = {test: end for test, end in ends.items() if end != "begun"}
    return over, sum((tried.get(test, Counter()) for test in over), Counter())


class Hang(BaseException):
    """A try that does not end; no handler of the program catches it."""


@contextmanager
def limited(asked: float = LIMIT_S) -> Iterator[None]:
    """Raise Hang in a block that takes more CPU time than LIMIT_S; `asked` [s]: TERM before."""
    if sys.platform == "win32":
        yield
        return
    left = [asked] if asked < LIMIT_S else []

    def hang(number: int, frame: FrameType | None) -> None:
        if not left:
            raise Hang(f"more than {LIMIT_S} s")
        signal.setitimer(signal.ITIMER_PROF, LIMIT_S - left.pop())
        os.kill(os.getpid(), signal.SIGTERM)

    before = signal.signal(signal.SIGPROF, hang)
    signal.setitimer(signal.ITIMER_PROF, asked)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
