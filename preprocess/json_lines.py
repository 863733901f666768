"""Output of a batch for programs: one JSON object per line on the original standard output."""

import dataclasses
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .batch import Outcome


class JsonLines:
    """Writes each line immediately and as a whole."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def write_outcome(self, outcome: Outcome, place: str = "") -> None:
        """Write one outcome; `place` is not written."""
        self.write(dataclasses.asdict(outcome))

    def progress(self, line: str) -> None:
        """Write the name of the step that begins."""
        self.write({"progress": line})

    def write(self, content: dict[str, Any]) -> None:
        """One line."""
        os.write(self._descriptor, (json.dumps(content) + "\n").encode())


@contextmanager
def json_lines() -> Iterator[JsonLines]:
    """Reserve standard output for the lines; output of libraries goes to standard error."""
    sys.stdout.flush()
    descriptor = os.dup(1)
    os.dup2(2, 1)
    try:
        yield JsonLines(descriptor)
    finally:
        sys.stdout.flush()
        os.dup2(descriptor, 1)
        os.close(descriptor)
