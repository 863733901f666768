"""Dotted keys of a mechanism's plain data, as sweeps and changed runs name numbers."""

from collections.abc import Mapping
from copy import copy
from typing import Any


def split_key(key: str) -> list[str]:
    """Return the parts of a dotted key of a case.

    After a colon it is a key of a description: "sections.tube:laminates.wall.angles_deg.1" is
    the change "laminates.wall.angles_deg.1" of the table sections.tube.
    """
    owner, colon, inner = key.partition(":")
    return [*owner.split("."), *(["changes", inner] if colon else [])]


def put(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return plain data with other values at dotted keys; numbers are places of lists.

    What does not change is shared with `table`.
    """
    found = dict(table)
    for key, value in changes.items():
        here: Any = found
        *way, last = split_key(key)
        for part in way:
            place: Any = int(part) if isinstance(here, list) else part
            here[place] = copy(here[place])
            here = here[place]
        here[int(last) if isinstance(here, list) else last] = value
    return found
