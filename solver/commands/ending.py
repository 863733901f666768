"""How a command ends: exit codes, defects, output that nobody reads."""

import os
import sys
import tempfile
import traceback
from collections.abc import Iterable
from contextlib import suppress
from typing import TextIO

from ..errors import escape_control_characters
from ..interrupts import INTERRUPTED

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


# Input, output and error stream of a command: closed, full, or without a reader.

NO_READER = 141  # exit code: as of a program that SIGPIPE ends


def complete() -> None:
    """Open streams that are closed, to nowhere.

    Otherwise the next file that is opened takes the number of one, and messages go into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()
    escape_control_characters()


def no_reader() -> int:
    """Drop what is still to be printed: the reader has closed the pipe, like `head`."""
    _drop_output()
    return NO_READER


def full_output(error: OSError) -> int | None:
    """Return an exit code if output cannot be written, None if the error is another one."""
    if error.filename is not None or error.errno is None:
        return None
    try:
        print(flush=True)  # what was refused before is forgotten
    except OSError as found:
        _drop_output()
        print(f"error: standard output: {found.strerror}", file=sys.stderr)
        return INPUT
    return None


def _drop_output() -> None:
    with suppress(OSError):  # a stream that is no file has nothing left
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")
