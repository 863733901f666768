"""TOML files as plain tables."""

import tomllib
from pathlib import Path
from typing import Any

from ...errors import InputError

CASE = "case file"
# Keys that only one kind of file has: one message about them says more than one about each key.
DESCRIPTION = "description for `plymotion section` or `plymotion shell`"
KEYS = {"runs": CASE, "joints": CASE, "regions": DESCRIPTION}


def read_toml(file: Path, what: str) -> dict[str, Any]:
    """Read a TOML file; `what` it is meant to be ("case file") goes into the message.

    Raises
    ------
    InputError
        No such file; not TOML; a file of another kind.
    """
    if file.exists() and not file.is_file():  # a folder, or a device that never ends
        raise InputError(f"{file}: no such {what}")
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, IsADirectoryError) as error:
        raise InputError(f"{file}: no such {what}") from error
    except RecursionError:
        raise InputError(f"{file}: not valid TOML: nested too deep; expected 100 levels") from None
    except ValueError as error:  # of the syntax, of UTF-8, or a number of thousands of digits
        raise InputError(f"{file}: not valid TOML: {error}") from error
    kind = next((kind for key, kind in KEYS.items() if key in table), None)
    if kind is not None and (kind == CASE) != (what == CASE):
        raise InputError(f"{file}: expected a {what}, found a {kind}")
    return table
