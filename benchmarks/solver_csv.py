"""Tables of the charts as CSV, complete or not at all."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from plymotion.solver.package.common.files import temporary_sibling


def write(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows of equal keys; numbers to four digits, which is more than a timing is worth."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        temporary_sibling(path, own=True) as temporary,
        temporary.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows({k: _short(v) for k, v in row.items()} for row in rows)


def read(path: Path) -> list[dict[str, str]]:
    """Rows as text."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _short(value: object) -> object:
    return f"{value:.4g}" if isinstance(value, float) else value
