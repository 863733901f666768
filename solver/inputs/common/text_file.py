"""Text files with numbers in lines, such as those that spreadsheets write."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO


def read_text(file: Path) -> str:
    """Return the text of a file. Raises ValueError: no such file, or no text in UTF-8."""
    with _opened(file) as text:
        return text.read()


def lines_of(file: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a file with their numbers, without empty lines and remarks after #.

    One line is in memory at a time. Raises ValueError as `read_text`.
    """
    with _opened(file) as text:
        for number, line in enumerate(text, start=1):
            if line.strip() and not line.lstrip().startswith("#"):
                yield number, line.rstrip("\n")


def numbered_lines(file: Path) -> list[tuple[int, str]]:
    """Return `lines_of` a file as a list."""
    return list(lines_of(file))


@contextlib.contextmanager
def _opened(file: Path) -> Iterator[TextIO]:
    if file.exists() and not file.is_file():  # a folder, or a device that never ends
        raise ValueError(f"{file}: cannot be read (expected a file)")
    try:
        with file.open(encoding="utf-8-sig") as text:
            yield text
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: cannot be read ({error})") from error
