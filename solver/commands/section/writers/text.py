"""Text files that appear only when they are complete."""

from collections.abc import Iterable
from pathlib import Path

from ....package.common.temporary import temporary_sibling


def written(file: Path, lines: Iterable[str]) -> Path:
    """Write lines to a file; returns the file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(file) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file
