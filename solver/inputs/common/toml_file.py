"""TOML files as plain tables."""

import tomllib
from pathlib import Path
from typing import Any

from ...errors import InputError

LEVELS = 100  # of tables and lists in each other
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
    too_deep = f"{file}: not valid TOML: nested too deep; expected {LEVELS} levels"
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, IsADirectoryError) as error:
        raise InputError(f"{file}: no such {what}") from error
    except RecursionError:
        raise InputError(too_deep) from None
    except ValueError as error:  # of the syntax, of UTF-8, or a number of thousands of digits
        raise InputError(f"{file}: not valid TOML: {error}") from error
    if not _flat_enough(table):  # as a key of many dots
        raise InputError(too_deep)
    kind = next((kind for key, kind in KEYS.items() if key in table), None)
    if kind is not None and (kind == CASE) != (what == CASE):
        raise InputError(f"{file}: expected a {what}, found a {kind}")
    return table


def _flat_enough(table: dict[str, Any]) -> bool:
    level: list[Any] = [table]
    for _ in range(LEVELS):
        within = [item.values() if isinstance(item, dict) else item for item in level]
        level = [item for items in within for item in items if isinstance(item, dict | list)]
        if not level:
            return True
    return False
