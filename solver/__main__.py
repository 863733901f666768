"""The command line: check, compile, packages, run, modes, report, section, shell, sweep, ..."""

if __name__ == "__main__":
    from .system.interrupts import begin_program

    begin_program()

import argparse
import atexit
import gc
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from .commands.parser import NAMES, parser, run_command
from .errors import InputError, PackageError, escape_control_characters
from .inputs.case.record import CASE_FILE
from .inputs.common.mesh_files import scripts
from .package.common.files import named_by_user
from .studies.exit_codes import INPUT, shown
from .system.interrupts import (
    INTERRUPTED,
    ending_words,
    exit_code,
    handled_signals,
    ignore,
    of_a_signal,
    stop_requested,
)

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


def full_output(error: OSError) -> int | None:
    """Return an exit code if output cannot be written, None if the error is another one."""
    if error.filename is not None or error.errno is None:
        return None
    try:
        print(flush=True)  # what was refused before is forgotten
    except OSError as cause:
        _drop_output()
        print(f"error: standard output: {cause.strerror}", file=sys.stderr)
        return INPUT
    return None


def _drop_output() -> None:
    with suppress(OSError):  # a stream that is no file has nothing left
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")


def main(arguments: list[str] | None = None) -> int:
    """Run one command; return the exit code.

    0 done; 2 wrong input, or errors found by `info`; 3 a run, or members of a sweep,
    ended early and their results up to that time are kept, or the findings of a run call its
    results invalid; 70 a defect of the program; 130, 143, 129 ended by Ctrl-C, TERM or HUP, results
    are kept; 141 the reader of the output has gone.
    """
    ended: list[int] = []
    if arguments is None:
        atexit.register(_end_at_once, ended)
        # Pydantic would search all installed packages for plugins: 0.02 s.
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        complete()
    words = sys.argv[1:] if arguments is None else arguments
    # "plymotion solver sweep" is "plymotion sweep", as is "python -m plymotion.solver sweep".
    if words[:1] == ["solver"]:
        words = words[1:]
    # "plymotion case.toml" is "plymotion run case.toml", unless a command has the folder's name.
    if words and words[0] not in NAMES and _is_case(words[0]):
        words = ["run", *words]
    options = parser(*words[:1]).parsed(words)
    try:
        with handled_signals():
            code = exit_code(_guarded(options))
    except KeyboardInterrupt:  # while a message was printed, or between two handlers
        code = exit_code(_interrupted())
    if arguments is None:
        ignore()  # all is done: a signal while Python ends would only be a traceback
        ended.append(code)
        if stop_requested():  # threads may be at work
            _end_at_once(ended)
    return code


def _end_at_once(ended: list[int]) -> None:
    """End the process with an exit code, if there is one, when all else at the end is done.

    Python would free what was imported and computed, object by object: 10 ms, and more after long
    runs. Looking for garbage before takes 30 ms.
    """
    gc.freeze()
    if ended and "multiprocessing.resource_tracker" not in sys.modules:
        for stream in filter(None, (sys.stdout, sys.stderr)):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(ended[0])


def _is_case(word: str) -> bool:
    return word.endswith(".toml") or os.path.isfile(f"{word}/{CASE_FILE}")


def _guarded(options: argparse.Namespace) -> int:
    """Run a command; turn what it raises into a message and an exit code."""
    try:
        with (
            shown(steps=not getattr(options, "quiet", False)),
            scripts(allowed=not getattr(options, "no_scripts", False)),
            named_by_user(_paths(options)),
        ):
            _check_paths(options)
            code = run_command(options)
            sys.stdout.flush()  # a full disk or a closed pipe raises here
            return code
    except (InputError, PackageError) as error:
        if of_a_signal(error):
            return _interrupted()
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader has closed the pipe, like `head`.
        _drop_output()
        return NO_READER
    except OSError as error:
        ended = full_output(error)
        if ended is not None:
            return ended
        where = f"{error.filename}: " if error.filename else ""
        print(f"error: {where}{error.strerror or error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return _interrupted()
    except Exception as error:
        if of_a_signal(error):
            return _interrupted()
        from .studies.exit_codes import DEFECT, report

        print(f"error: {report(error)}", file=sys.stderr)
        return DEFECT


def _paths(options: argparse.Namespace) -> list[Path]:
    """Return all paths of a command line; of build/CASE/runs/RUN.json also build/CASE."""
    values = [v for value in vars(options).values() for v in _listed(value) if isinstance(v, Path)]
    return [*values, *(path.parent.parent for path in values if path.suffix == ".json")]


def _check_paths(options: argparse.Namespace) -> None:
    """Raise InputError for a device or a pipe, which may never end, or wait for a writer."""
    for path in _paths(options):
        if os.path.exists(path) and not (os.path.isfile(path) or os.path.isdir(path)):
            raise InputError(f"{path}: expected a file, found a device or a pipe")


def _listed(value: object) -> list[object]:
    return value if isinstance(value, list) else [value]


def _interrupted() -> int:
    print(ending_words(), file=sys.stderr)
    return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
