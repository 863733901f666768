"""Errors that are none of the user's: one sentence on the screen, the traceback in a file."""

import os
import tempfile
import traceback

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
