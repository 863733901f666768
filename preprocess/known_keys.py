"""Tables with keys that nobody knows."""

from collections.abc import Mapping
from typing import Any

from ..solver.errors import did_you_mean


def check_keys(table: Any, known: tuple[str, ...], where: str, error: type[Exception]) -> None:
    """Raise `error` for what is no table, and for the first unknown key; names the nearest."""
    if not isinstance(table, Mapping):
        raise error(f"{where} = {table!r}: expected a table")
    for key in table:
        if key not in known:
            raise error(
                f"{where}.{key}: unknown key, expected {', '.join(known)}"
                + did_you_mean(str(key), known)
            )
