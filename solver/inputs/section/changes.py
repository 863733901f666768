"""Change of keys of a section description."""

import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from ...errors import InputError, nearest


def changed(table: dict[str, Any], changes: Mapping[str, Any], file: Path) -> dict[str, Any]:
    """Return the table of a description with other values.

    Parameters
    ----------
    changes : dotted key, with numbers for positions in a list, and its value
    file : of the table, for messages

    Raises
    ------
    InputError : a key that does not exist.
    """
    table = deepcopy(table)
    for key, value in changes.items():
        *path, last = _parts(key)
        place: Any = table
        for i, part in enumerate(path):
            if _at(place, part) not in _known(place):
                raise InputError(
                    f"{file}: {'.'.join(path[: i + 1])}: no such table, needed for the change of "
                    f'"{key}"{nearest(part, map(str, _known(place)))}'
                )
            place = place[_at(place, part)]
        if not isinstance(place, dict) and _at(place, last) not in _known(place):
            raise InputError(f'{file}: {".".join(path)}: has no {last}, the change of "{key}"')
        place[_at(place, last)] = value
    return table


def _parts(key: str) -> list[str]:
    """Return the parts of a dotted key, by the rules of TOML."""
    parts: list[str] = []
    try:
        inner: Any = tomllib.loads(f"{key} = 0")
        while isinstance(inner, dict):
            ((part, inner),) = inner.items()
            parts.append(part)
    except ValueError as error:
        raise InputError(f'sweep.key = "{key}": not a dotted key of TOML: {error}') from error
    return parts


def _at(place: Any, part: str) -> str | int:
    return int(part) if isinstance(place, list) and part.isdecimal() else part


def _known(place: Any) -> list[Any]:
    """Keys of a table, positions of a list; none of a value."""
    if isinstance(place, dict):
        return list(place)
    return list(range(len(place))) if isinstance(place, list) else []
