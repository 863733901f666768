"""The table of a batch, one row for each section: as CSV, as JSON and as text."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...package.common.plain_data import cell_text
from ...package.common.temporary import write_text
from .results import SectionResults
from .show import section_json

SHOWN = 40  # most rows on the screen; the files have all
UPPER = [(i, j) for i in range(6) for j in range(i, 6)]


@dataclass(frozen=True)
class Row:
    """One section of a batch."""

    name: str
    status: str  # "built", "unchanged", "failed"
    changes: dict[str, Any]
    results: SectionResults | None = None
    error: str = ""


def write_summary(folder: Path, stem: str, rows: Sequence[Row]) -> list[Path]:
    """Write the table as folder/stem.csv and folder/stem.json; returns the two files."""
    texts = {".csv": _csv(rows), ".json": json.dumps(summary_json(rows), indent=1) + "\n"}
    files = []
    for suffix, text in texts.items():
        files.append(folder / f"{stem}{suffix}")
        write_text(files[-1], text)
    return files


def summary_json(rows: Sequence[Row]) -> dict[str, Any]:
    """Return status, changes and numbers (or the error) of each section by name."""
    return {
        row.name: {"status": row.status, "changes": row.changes}
        | (section_json(row.results) if row.results else {"error": row.error})
        for row in rows
    }


def _csv(rows: Sequence[Row]) -> str:
    keys = list(dict.fromkeys(key for row in rows for key in row.changes))
    head = ["name", "status", *keys, *(f"K{i + 1}{j + 1}" for i, j in UPPER), "mass"]
    for centre in ("mass_centre", "shear_centre", "tension_centre"):
        head += [f"{centre}_x2", f"{centre}_x3"]
    head += ["error_estimate_scaled", "dofs", "seconds", "warnings", "error"]
    stream = io.StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow(head)
    for row in rows:
        changes = [json.dumps(row.changes[key]) if key in row.changes else "" for key in keys]
        numbers = _numbers(row.results) if row.results else [""] * (len(UPPER) + 11)
        texts = cell_text(row.name), row.status, cell_text(row.error)
        writer.writerow([*texts[:2], *changes, *numbers, texts[2]])
    return stream.getvalue()


def _numbers(results: SectionResults) -> list[Any]:
    worst = results.worst_error
    return [
        *(results.K[i, j] for i, j in UPPER),
        results.M[0, 0],
        *results.mass_centre,
        *results.shear_centre,
        *results.tension_centre,
        "" if worst is None else worst,
        results.dofs,
        results.seconds,
        " ".join(warning["code"] for warning in results.warnings),
    ]


def summary_text(rows: Sequence[Row]) -> str:
    """Return the first rows as a table of at most 100 columns."""
    width = min(30, max([len("name"), *(len(row.name) for row in rows)]))
    lines = [
        f"{'name':{width}}{'K11':>11}{'K44':>11}{'K55':>11}{'K66':>11}{'mass':>9}{'error':>9}"
        f"{'time':>7}",
        f"{'':{width}}{'[N]':>11}{'[N m2]':>11}{'[N m2]':>11}{'[N m2]':>11}{'[kg/m]':>9}{'[-]':>9}"
        f"{'[s]':>7}",
    ]
    for row in rows[:SHOWN]:
        values = " ".join(json.dumps(value) for value in row.changes.values())
        line = f"{_cut(row.name, width):{width}}{_cells(row)}  {values}"
        lines.append(_cut(line.rstrip(), 100))
    if len(rows) > SHOWN:
        lines.append(f"... and {len(rows) - SHOWN} more in the table")
    if any(row.results and row.results.warnings for row in rows):
        lines.append("* with warnings, see the table")
    return "\n".join(lines)


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width - 1]}…"


def _cells(row: Row) -> str:
    results = row.results
    if results is None:
        return f"{'failed':>11}{'':58}"
    numbers = "".join(f"{results.K[i, i]:11.4g}" for i in (0, 3, 4, 5))
    worst = "-" if results.worst_error is None else f"{results.worst_error:.1e}"
    star = "*" if results.warnings else " "
    return f"{numbers}{results.M[0, 0]:9.4g}{worst:>9}{results.seconds:7.2f}{star}"
