"""Input, output and error stream of a command: closed, full, or without a reader."""

import os
import sys
from contextlib import suppress
from typing import TextIO

from ..errors import escape_control_characters
from ..studies.exit_codes import INPUT

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
