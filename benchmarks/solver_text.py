"""Tables of docs/speed.md from the numbers of solver_speed.py."""

import os
import platform
from pathlib import Path
from typing import Any

import numpy as np
from shell_text import replace_between
from solver_curves import cpu_at


def write_tables(found: dict[str, Any], document: Path) -> None:
    """Renew every table of the document that there are numbers for."""
    for name, lines in {
        "double_pendulum": _double_pendulum,
        "chain": _chain,
        "ensemble": _ensemble,
    }.items():
        if found.get(name):
            text = lines(found[name])
            replace_between(document, name.replace("_", " "), [*text, "", _machine()])


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    return [_row(head), _row(["---"] * len(head)), *map(_row, rows)]


def _seconds(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "–"


def _double_pendulum(found: dict[str, Any]) -> list[str]:
    curves = {
        "Exudyn, full Newton (its default)": found["exudyn"],
        "Exudyn, modified Newton": found["exudyn_modified_newton"],
        **found["plymotion"],
    }
    targets = list(found["ratio_at"])
    rows = [
        [name, *(_seconds(cpu_at(curve, float(target))) for target in targets)]
        for name, curve in curves.items()
    ]
    for key, words in (
        ("ratio_at", "best of ours / Exudyn, full Newton"),
        ("ratio_at_modified_newton", "best of ours / Exudyn, modified Newton"),
    ):
        rows.append([f"**{words}**", *(_ratio(found[key][t]) for t in targets)])
    head = ["processor time [s] for a tip error of", *(f"{t} m" for t in targets)]
    return [
        *_table(head, rows),
        "",
        "Limit of Exudyn's tip from ours, extrapolated: "
        + "; ".join(f"{name} {value:.1e} m" for name, value in found["limits"].items())
        + ".",
    ]


def _ratio(value: float | None) -> str:
    if value is None:
        return "–"
    return f"**{value:.3g}**" + (f" (1/{1 / value:.1f})" if value < 1 else "")


def _chain(found: dict[str, Any]) -> list[str]:
    curves = {
        **{f"ours, {name}": row for name, row in found["every_us_per_link_step"].items()},
        "Exudyn, full Newton": found["exudyn_us_per_link_step"],
        "Exudyn, modified Newton": found["exudyn_modified_newton_us_per_link_step"],
    }
    links = sorted({int(n) for row in curves.values() for n in row})
    rows = [
        [name, *(f"{row[str(n)]:.3g}" if str(n) in row else "–" for n in links)]
        for name, row in curves.items()
    ]
    return _table(["us per link and step, links:", *map(str, links)], rows)


def _ensemble(found: dict[str, Any]) -> list[str]:
    rows = [
        [key.replace("_", " "), f"{value:.4g}" if isinstance(value, float) else str(value)]
        for key, value in found.items()
        if not isinstance(value, list)
    ]
    return _table(["ensemble", "measured"], rows)


def _machine() -> str:
    model = platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}."
