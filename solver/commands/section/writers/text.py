"""Text files that appear only when they are complete."""

from collections.abc import Iterable
from pathlib import Path

from ....package.common.temporary import write_text


def written(file: Path, lines: Iterable[str]) -> Path:
    """Write lines to a file; returns the file."""
    write_text(file, "\n".join(lines) + "\n")
    return file
