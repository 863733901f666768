"""Progress output of the commands that make files, and file names from standard input."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .batch import Outcome, Product, build_all, print_outcome
from .json_lines import json_lines

Report = Callable[[Outcome, str], None]


def build_from_stdin(
    product: Product, target_of: Callable[[Path], Path], *, force: bool, report: Report
) -> int:
    """Make a file for each name of a specification read from standard input."""
    code = 0
    for line in sys.stdin:
        path = Path(line.rstrip("\n"))
        code = max(code, build_all(product, [path], target_of, force=force, report=report))
    return code


@contextmanager
def reporter(as_json: bool, first: bool) -> Iterator[tuple[Report, Callable[[str], None] | None]]:
    """Reporter of outcomes and progress: only the first rank reports, as text or as JSON."""
    if not first:
        yield _no_report, None
    elif as_json:
        with json_lines() as lines:
            yield lines.write_outcome, lines.progress
    else:
        yield print_outcome, None


def _no_report(outcome: Outcome, place: str) -> None:
    """Reporter of the other ranks: prints nothing."""
