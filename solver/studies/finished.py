"""Record of a finished command, which is skipped if its inputs and results are unchanged.

Files of the user are compared by size and time, as make does: results may be large. A change of
either only leads to the comparison by content that every stage does for itself.
"""

import json
import sys
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from ..math.disk_cache import sources_sha256, state_of

RECORD = "finished.json"
MOST = 32  # commands that are remembered for a folder


def request_of(file: Path, words: dict[str, object]) -> str:
    """Return a name for what a command was asked to do."""
    return json.dumps({"case": str(file.resolve()), **words}, sort_keys=True)


def finished_before(out: Path, request: str) -> tuple[int, str] | None:
    """Return exit code and last line of an earlier command if it need not be done again."""
    try:
        entry = _commands(out)[request]
        if entry["program"] == _program() and _same(Path(), entry["inputs"]):
            return (
                (int(entry["code"]), str(entry["text"])) if _same(out, entry["results"]) else None
            )
    except (KeyError, TypeError, ValueError, AttributeError):
        pass
    return None


def refuse_foreign_record(out: Path) -> None:
    """Raise InputError if the place of the record has a file that is none."""
    from ..package.common.files import refuse_foreign

    if not _commands(out):
        refuse_foreign(out / RECORD)


def note_finished(
    out: Path,
    request: str,
    code: int,
    text: str,
    inputs: Mapping[Path, list[int]],
    results: Iterable[Path],
    shared: Collection[str] = (),
) -> None:
    """Remember a command.

    Parameters
    ----------
    inputs : files that it depends on, besides the program, with their states when they were read
    results : files in `out` that it has made or used
    shared : names of results that other commands add to: these must only be there
    """
    from ..package.common.files import write_text  # imports NumPy

    commands = _commands(out)
    commands.pop(request, None)
    commands[request] = {
        "code": code,
        "text": text,
        "program": _program(),
        "inputs": {str(file.absolute()): state for file, state in inputs.items()},
        "results": {
            file.relative_to(out).as_posix(): None if file.name in shared else state_of(file)
            for file in results
        },
    }
    recent = dict(list(commands.items())[-MOST:])
    write_text(out / RECORD, json.dumps({"commands": recent}) + "\n", own=True)


def _program() -> list[str]:
    """Return the digest of all sources, and the Python that runs them."""
    return [sources_sha256("solver", "preprocess", "meshes"), sys.version, sys.prefix]


def _commands(out: Path) -> dict[str, Any]:
    try:
        found = json.loads((out / RECORD).read_text(encoding="utf-8"))["commands"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _same(folder: Path, states: dict[str, Any]) -> bool:
    return all(
        state_of(folder / name) == state
        if state is not None
        else any(state_of(folder / name)[:1])  # there, and not empty
        for name, state in states.items()
    )
