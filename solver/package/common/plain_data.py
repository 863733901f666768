"""Plain data (JSON) as text that depends only on the content, and its hash."""

import hashlib
import json
from typing import Any

# The path of a mesh does not affect results: next to these keys, `sha256` is the hash of its
# content.
PLACES = ("file", "arrays")
DIGITS = 12  # the last ones of a cosine in the spacing of a mesh depend on the machine


def canonical(data: Any) -> str:
    """Return the JSON text that is the same for the same content."""
    return json.dumps(data, sort_keys=True)


def cell_text(text: str) -> str:
    """Return a text as a cell of a CSV table that no spreadsheet takes for a formula."""
    return f"'{text}" if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text


def data_sha256(data: Any) -> str:
    """Return the hash of plain data with all digits."""
    return hashlib.sha256(canonical(data).encode()).hexdigest()


def inputs_sha256(data: Any) -> str:
    """Return the hash of a specification: meshes by their content, numbers to `DIGITS` digits."""
    return data_sha256(_inputs(data))


def _inputs(data: Any) -> Any:
    if isinstance(data, dict):
        left_out = PLACES if "sha256" in data else ()
        return {key: _inputs(value) for key, value in data.items() if key not in left_out}
    if isinstance(data, list | tuple):
        return [_inputs(value) for value in data]
    return float(f"{data:.{DIGITS}g}") if isinstance(data, float) else data
