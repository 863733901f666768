"""Tables as TOML text: descriptions that a program writes and a user reads."""

import json
from typing import Any


def toml_text(table: dict[str, Any], path: str = "") -> str:
    """Return plain values, lists and tables as TOML text."""
    lines = [f"{_key(k)} = {toml_value(v)}" for k, v in table.items() if not isinstance(v, dict)]
    for key, value in table.items():
        if isinstance(value, dict):
            name = f"{path}{_key(key)}"
            lines += [f"\n[{name}]", toml_text(value, f"{name}.").rstrip("\n")]
    return "\n".join(lines).lstrip("\n") + "\n"


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else toml_value(key)


def toml_value(value: Any) -> str:
    """Return a value on one line; a table within a list becomes an inline table."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {toml_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    # JSON with its own letters: TOML has no pairs of surrogates, and takes no bare DEL.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
