"""Exit codes of commands, and internal errors."""

import os
import tempfile
import traceback
from collections.abc import Iterable

from ..system.interrupts import INTERRUPTED

# Exit codes of the commands.

INPUT = 2  # something is wrong with an input
INCOMPLETE = 3  # a run ended early, or its results are not valid to the end; what there is, is kept


def worst(codes: Iterable[int]) -> int:
    """Return the exit code of several parts of a command."""
    found = set(codes)
    return next((code for code in (INTERRUPTED, DEFECT, INPUT, INCOMPLETE) if code in found), 0)


# Internal errors: one sentence on the screen, the traceback in a file.

DEFECT = 70  # exit code: internal software error


def report(error: BaseException) -> str:
    """Write the traceback to a new file; return one sentence that names it."""
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
