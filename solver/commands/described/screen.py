"""What is shown of results files: numbers or JSON, failures, names of files."""

import json
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from ...errors import InputError
from .make import Made

USER_ERROR = 2


def show_each(
    made: Sequence[Made],
    table_of: Callable[[Made], Any],
    text_of: Callable[[Made], str],
    *,
    as_json: bool,
) -> int:
    """Show one after the other, as text or as one JSON table; returns the exit code."""
    tables: dict[str, Any] = {}
    code = 0
    for one in made:
        if one.status == "failed":
            code = USER_ERROR
            tell_failure(one)
            tables[one.entry.name] = {"error": one.error}
        elif as_json:
            tables[one.entry.name] = table_of(one)
        else:
            print(text_of(one), end="\n" if one is made[-1] else "\n\n")
    if as_json and not (code and len(made) == 1):
        print(json.dumps(next(iter(tables.values())) if len(made) == 1 else tables))
    return code


def tell_failure(one: Made) -> None:
    """Say on standard error why a file has not been made."""
    if one.defect:
        print(one.defect, end="", file=sys.stderr)
        print("this is a defect of the preprocessor, not of the input:", file=sys.stderr)
    for line in one.error.splitlines():
        print(f"error: {line}", file=sys.stderr)


def file_lines(one: Made, figures: Iterable[Path]) -> str:
    """Names of a results file and its figures."""
    note = " (unchanged)" if one.status == "unchanged" else ""
    first = f"{'Files':16}{one.file}{note}"
    return "\n".join([first, *(f"{'':16}{figure}" for figure in figures)])


def drawn(draw: Callable[[], list[Path]], known: Sequence[Path], file: Path) -> list[Path]:
    """Return the figures of a file: those that are there if none is older, else drawn again.

    Parameters
    ----------
    known : figures that are there, or should be
    """
    made = file.stat().st_mtime
    if known and all(figure.is_file() and figure.stat().st_mtime >= made for figure in known):
        return list(known)
    try:
        return draw()
    except (InputError, ModuleNotFoundError) as error:  # the numbers are still there
        print(f"no figures: {error}; they need pip install plymotion[plot]", file=sys.stderr)
        return []
