"""How a command ends: messages on the screen, internal errors, exit codes."""

import logging
import os
import sys
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from ..system.interrupts import INTERRUPTED

# Exit codes of the commands.

INPUT = 2  # something is wrong with an input
INCOMPLETE = 3  # a run ended early, or its results are not valid to the end; what there is, is kept


def worst(codes: Iterable[int]) -> int:
    """Return the exit code of several parts of a command."""
    present = set(codes)
    return next((code for code in (INTERRUPTED, DEFECT, INPUT, INCOMPLETE) if code in present), 0)


# Internal errors: one sentence on the screen, the traceback in a file.

DEFECT = 70  # exit code: internal software error


def report(error: BaseException) -> str:
    """Write the traceback to a new file; return one sentence that names it."""
    import tempfile  # 3 ms, for a defect only

    what = " ".join(str(error).split())[:200]
    name = type(error).__name__ + (f": {what}" if what else "")
    text = "".join(traceback.format_exception(error))
    try:
        number, path = tempfile.mkstemp(prefix="plymotion-traceback-", suffix=".txt")
        with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
        where = f"the traceback is in {path}"
    except OSError as cause:
        where = f"its traceback could not be written: {cause.strerror}"
    reason = "not enough memory" if isinstance(error, MemoryError) else "a defect of this program"
    return f"{reason} ({name}); {where}"


# Messages of the library on standard error: records of the logger "plymotion".


def bar_is_shown() -> bool:
    """Return whether a progress bar is on the screen."""
    tqdm = sys.modules.get("tqdm")
    return tqdm is not None and bool(getattr(tqdm.tqdm, "_instances", None))


class _Screen(logging.Handler):
    """Writes each message to the standard error of that moment, above a progress bar if any."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write one message."""
        text = record.getMessage()
        if bar_is_shown():
            sys.modules["tqdm"].tqdm.write(text, file=sys.stderr)
        else:
            sys.stderr.write(f"{text}\n")
            sys.stderr.flush()


@contextmanager
def shown(*, steps: bool) -> Iterator[None]:
    """Show messages as long as a block runs: warnings and errors; `steps`: also what is done."""
    logger, handler = logging.getLogger("plymotion"), _Screen()
    before = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.INFO if steps else logging.WARNING)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before[0])
        logger.propagate = before[1]
