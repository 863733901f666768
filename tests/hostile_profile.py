"""How long the attack is, and what it counts: quick, or long with PLYMOTION_ATTACK."""

import json
import os
import signal
import sys
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
LIMIT_S = 60.0  # CPU time of a try after which it hangs


def tries(quick: int, long: int) -> int:
    """Number of tries of a test."""
    return long if RECORD else quick


def count(kind: str, end: str) -> None:
    """Count a try of a kind by its end; kept with PLYMOTION_ATTACK only."""
    assert end in GOOD + BAD
    if RECORD:
        with Path(RECORD).open("a", encoding="utf-8") as file:
            file.write(json.dumps([kind, end]) + "\n")


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
        os.kill(os.getpid(), signal.SIGTERM)  # INT is ignored in the background

    before = signal.signal(signal.SIGPROF, hang)
    signal.setitimer(signal.ITIMER_PROF, asked)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
