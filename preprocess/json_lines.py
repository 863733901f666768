"""What a batch tells to a program: JSON, one object a line, on what was standard output."""

import dataclasses
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .batch import Outcome


class JsonLines:
    """Writes lines at once, each in one piece."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def tell(self, outcome: Outcome, place: str = "") -> None:
        """One outcome; its place in a list is for people."""
        self.write(dataclasses.asdict(outcome))

    def progress(self, line: str) -> None:
        """What begins now."""
        self.write({"progress": line})

    def write(self, content: dict[str, Any]) -> None:
        """One line."""
        os.write(self._descriptor, (json.dumps(content) + "\n").encode())


@contextmanager
def json_lines() -> Iterator[JsonLines]:
    """Keep standard output for the lines: what libraries print goes to standard error."""
    sys.stdout.flush()
    descriptor = os.dup(1)
    os.dup2(2, 1)
    try:
        yield JsonLines(descriptor)
    finally:
        sys.stdout.flush()
        os.dup2(descriptor, 1)
        os.close(descriptor)
