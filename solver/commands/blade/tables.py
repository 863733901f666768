"""Tables of a windIO file: entries by key, with messages that name file and key."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, nearest
from ...math.arrays import Array
from .along import NEAR, Along

LARGEST = 1e30  # squares and products of larger numbers overflow
Table = Mapping[str, Any]


class Tables:
    """Reads entries of a file; every method raises InputError if an entry is not as expected."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def error(self, key: str, words: str) -> InputError:
        """Return an error that names the file and the key."""
        return InputError(f"{self.file}: {key}: {words}")

    def table(self, parent: Table, path: str) -> dict[str, Any]:
        """Return the table of the last part of `path`."""
        key = path.rpartition(".")[2]
        found = parent.get(key)
        if not isinstance(found, dict):
            known = [str(name) for name in parent if name != key]
            hint = nearest(key, known) if found is None else ""
            words = "missing" if found is None else f"has {_kind(found)}"
            raise self.error(path, f"{words}; expected a table of windIO 2{hint}")
        return found

    def entries(self, parent: Table, path: str, *, required: bool = False) -> list[dict[str, Any]]:
        """Return the list of tables of the last part of `path`; without it, none."""
        found = parent.get(path.rpartition(".")[2])
        if found is None and not required:
            return []
        if not isinstance(found, list):
            words = "missing" if found is None else f"has {_kind(found)}"
            raise self.error(path, f"{words}; expected a list of tables")
        for i, entry in enumerate(found):
            if not isinstance(entry, dict):
                raise self.error(f"{path}[{i}]", f"has {_kind(entry)}; expected a table")
        return found

    def text(self, parent: Table, path: str) -> str:
        """Return the name of the last part of `path`."""
        found = parent.get(path.rpartition(".")[2])
        if isinstance(found, bool) or not isinstance(found, str | int | float):
            words = "missing" if found is None else f"has {_kind(found)}"
            raise self.error(path, f"{words}; expected a name")
        return str(found)

    def numbers(self, parent: Table, path: str, count: int | None = None) -> Array:
        """Return numbers (count,) of the last part of `path`; without count, one or more."""
        found = parent.get(path.rpartition(".")[2])
        if found is None:
            raise self.error(path, "missing; expected numbers")
        wanted = "numbers" if count is None else f"{count} numbers" if count > 1 else "a number"
        try:
            values = np.array(found if count != 1 else [found], dtype=float)
        except (TypeError, ValueError, OverflowError):
            values = np.array(np.nan)
        if values.ndim != 1 or len(values) != (count or max(len(values), 1)):
            raise self.error(path, f"has {_kind(found)}; expected {wanted}")
        if not (np.abs(values) <= LARGEST).all():
            raise self.error(path, f"expected {wanted}, finite ones, up to {LARGEST:g}")
        return values

    def along(self, parent: Table, path: str) -> Along:
        """Return the quantity along the span of the last part of `path`."""
        found = parent.get(path.rpartition(".")[2])
        if not isinstance(found, dict) or not {"grid", "values"} <= found.keys():
            words = "missing" if found is None else f"has {_kind(found)}"
            words = "lacks grid or values" if isinstance(found, dict) else words
            raise self.error(path, f"{words}; expected a table with grid and values")
        grid, values = (self.numbers(found, f"{path}.{key}") for key in ("grid", "values"))
        if len(grid) != len(values):
            raise self.error(path, f"grid has {len(grid)} numbers and values {len(values)}")
        if (np.diff(grid) < 0).any():
            raise self.error(path, "expected a grid that rises")
        if grid[0] < -NEAR or grid[-1] > 1.0 + NEAR:
            words = f"{grid[0]:g} to {grid[-1]:g}; expected 0 at the root to 1 at the tip"
            raise self.error(f"{path}.grid", words)
        return Along(grid, values)


def _kind(found: Any) -> str:
    """What an entry is, in words for a message."""
    if isinstance(found, dict):
        return "a table"
    if isinstance(found, list):
        return f"a list of {len(found)}"
    return repr(found)
