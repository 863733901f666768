"""Check of the keys of a table."""

from collections.abc import Mapping
from typing import Any

from ..solver.errors import did_you_mean


def check_keys(table: Any, known: tuple[str, ...], where: str, error: type[Exception]) -> None:
    """Raise `error` if this is not a table, or for its first unknown key, with the nearest one."""
    if not isinstance(table, Mapping):
        raise error(f"{where} = {table!r}: expected a table")
    for key in table:
        if key not in known:
            raise error(
                f"{where}.{key}: unknown key, expected {', '.join(known)}"
                + did_you_mean(str(key), known)
            )
