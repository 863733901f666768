"""Changes of inputs by chance: one place of a table, hostile values and words."""

import copy
import random
from collections.abc import Sequence
from typing import Any

EXTREMES = [0, -1, 1e308, -1e308, 5e-324, 10**30, -(2**63), True, False]
TEXTS = [
    "", " ", "$(shell touch P)", "`touch P`", "a#b", "a:b", "a%b", "two words", "a\nb", "a\x00b",
    "\u00e9", "../../../../etc/passwd", "/dev/zero", "/", "x" * 5000, "$\\foo{$", "1.0", "nan",
]  # fmt: skip
SCALES = [1e-3, 0.5, 0.9, 1.1, 2.0, 1e3, 1e9, 1e150]


def places(table: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Ways to all keys and entries of a table."""
    items = table.items() if isinstance(table, dict) else enumerate(table)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


def inner(table: Any, way: Sequence[Any]) -> Any:
    """Return what is at a way."""
    for key in way:
        table = table[key]
    return table


def changed(chance: random.Random, table: Any, ways: list[tuple[Any, ...]]) -> tuple[Any, str]:
    """Return a copy with one of these places deleted, repeated, scaled or replaced; and how."""
    table = copy.deepcopy(table)
    *way, last = chance.choice(ways)
    here = inner(table, way)
    kind = chance.choice(["delete", "repeat", "number", "number", "value"])
    if kind == "delete":
        del here[last]
    elif kind == "repeat" and isinstance(here, list):
        here.insert(last, here[last])
    elif kind == "number" and isinstance(here[last], float):
        here[last] *= chance.choice([*SCALES, -1.0, 1e-9, 1e300, float("inf"), float("nan")])
    else:
        kind = "value"
        here[last] = chance.choice([*EXTREMES, *TEXTS, [], {}, [[]], [1.0], {"a": 1}, [1.0] * 1000])
    return table, kind


def toml(value: Any) -> str:
    """One value as TOML, tables inline."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(k)} = {toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return _text(value) if isinstance(value, str) else repr(value)


def toml_file(table: dict[str, Any]) -> str:
    """A table as a file."""
    return "\n".join(f"{_text(k)} = {toml(v)}" for k, v in table.items())


def _text(word: str) -> str:
    safe = (c if c.isprintable() and c not in '"\\' else f"\\u{ord(c):04x}" for c in word)
    return '"' + "".join(safe) + '"'
