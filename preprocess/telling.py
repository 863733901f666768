"""Progress output of the commands that make files, and names read from standard input."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .batch import Outcome, Product, build_all, tell_text
from .json_lines import json_lines

Tell = Callable[[Outcome, str], None]


def answer(product: Product, target_of: Callable[[Path], Path], *, force: bool, tell: Tell) -> int:
    """Make a file for each name of a specification that arrives on standard input."""
    code = 0
    for line in sys.stdin:
        path = Path(line.rstrip("\n"))
        code = max(code, build_all(product, [path], target_of, force=force, tell=tell))
    return code


@contextmanager
def teller(as_json: bool, first: bool) -> Iterator[tuple[Tell, Callable[[str], None] | None]]:
    """Reporter of outcomes and progress: only the first rank reports, as text or as JSON."""
    if not first:
        yield _nothing, None
    elif as_json:
        with json_lines() as lines:
            yield lines.tell, lines.progress
    else:
        yield tell_text, None


def _nothing(outcome: Outcome, place: str) -> None:
    """Reporter of the other ranks: prints nothing."""
