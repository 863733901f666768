"""Which descriptions a command is given."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...errors import InputError


@dataclass(frozen=True)
class Entry:
    """One description, or a variant of one; or a results file that is shown again."""

    name: str
    file: Path
    changes: dict[str, Any] = field(default_factory=dict)  # dotted key -> value

    @property
    def where(self) -> str:
        """File and changes, for messages."""
        changes = ", ".join(f"{key} = {value}" for key, value in self.changes.items())
        return f"{self.file} with {changes}" if changes else str(self.file)


def entries_of(files: Iterable[Path]) -> list[Entry]:
    """One entry for each file, named after it; a file that is given twice counts once.

    Raises
    ------
    InputError : two have the same name, and so would have the same results.
    """
    known: dict[str, Path] = {}
    for file in files:
        if (other := known.setdefault(file.stem, file)) != file:
            raise InputError(
                f"{file}: its files would overwrite those of {other}; expected another name, or "
                "one at a time with --out"
            )
    return [Entry(name, file) for name, file in known.items()]
