"""Progress of the commands that make files: lines for people, or one JSON object per line."""

import dataclasses
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from .batch import Outcome, print_outcome

Report = Callable[[Outcome, str], None]
Progress = Callable[[str], None]


@contextmanager
def reporter(as_json: bool, first: bool) -> Iterator[tuple[Report, Progress | None]]:
    """Reporter of outcomes and progress: only the first rank reports, as text or as JSON.

    Lines of JSON go to the original standard output, immediately and as a whole; output of
    libraries goes to standard error.
    """
    if not first:
        yield lambda _outcome, _place: None, None
        return
    if not as_json:
        yield print_outcome, None
        return
    sys.stdout.flush()
    lines = os.dup(1)
    os.dup2(2, 1)

    def write(content: dict[str, Any]) -> None:
        os.write(lines, (json.dumps(content) + "\n").encode())

    try:
        yield (
            lambda outcome, _place: write(dataclasses.asdict(outcome)),
            lambda line: write({"progress": line}),
        )
    finally:
        sys.stdout.flush()
        os.dup2(lines, 1)
        os.close(lines)
