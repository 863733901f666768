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
        "ensemble": _ensemble,
        "chain": _chain,
        "memory": _memory,
        "limit": _limit,
    }.items():
        if found.get(name):
            text = lines(found[name])
            on = machine(found.get("load", {}).get(name))
            replace_between(document, name.replace("_", " "), [*text, "", on])


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    return [_row(head), _row(["---"] * len(head)), *map(_row, rows)]


def _seconds(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "–"


def _double_pendulum(found: dict[str, Any]) -> list[str]:
    peers = {
        "Exudyn, solution only, full Newton (its default)": found["exudyn"],
        "Exudyn, solution only, modified Newton": found["exudyn_modified_newton"],
    }
    targets = list(found["ratio_at"])
    rows = []
    for name, curve in {**peers, **found["plymotion"]}.items():
        cells = [_seconds(cpu_at(curve, float(target))) for target in targets]
        loop = found["bare"].get(name)
        bare = [_seconds(cpu_at(loop, float(t))) if loop else "" for t in targets[:1]]
        rows.append([name, *cells, *bare])
    for key, words in (
        ("ratio_at", "best of ours / Exudyn, full Newton"),
        ("ratio_at_modified_newton", "best of ours / Exudyn, modified Newton"),
    ):
        rows.append([f"**{words}**", *(_ratio(found[key][t]) for t in targets), ""])
    head = [
        "processor time [s] for a tip error of",
        *(f"{t} m" for t in targets),
        f"steps alone, {targets[0]} m",
    ]
    return [
        *_table(head, rows),
        "",
        "Limit of Exudyn's tip from ours, extrapolated: "
        + "; ".join(f"{name} {value:.1e} m" for name, value in found["limits"].items())
        + ".",
        "",
        *_phases(found["default"]),
    ]


def _phases(rows: list[dict[str, Any]]) -> list[str]:
    """The default integrator, phase by phase."""
    head = ["error below", "rtol", "error [m]", "steps", "build [ms]", "integration [ms]"]
    head += [
        "monitors [ms]",
        "signals, checks [ms]",
        "all [ms]",
        "Exudyn's solution [ms]",
        "integration with monitors / Exudyn",
        "all but build / Exudyn",
    ]
    cells = []
    for row in rows:
        phases = row["phases"]
        names = ("build", "integrate", "monitors", "recover")
        parts = [f"{1e3 * phases[k]:.3g}" for k in names]
        stepping = phases["integrate"] + phases["monitors"]
        cells.append(
            [
                f"{row['target']} m",
                f"{row['tolerance']:g}",
                f"{row['error']:.1e}",
                str(row["steps"]),
                *parts,
                f"{1e3 * row['cpu_s']:.3g}",
                f"{1e3 * row['exudyn_s']:.3g}",
                f"1/{row['exudyn_s'] / stepping:.1f}",
                f"1/{row['exudyn_s'] / (stepping + phases['recover']):.1f}",
            ]
        )
    return _table(head, cells)


def _memory(rows: list[dict[str, Any]]) -> list[str]:
    head = ["`plymotion run`", "peak memory [MB]", "processor time [s]", "result.vtkhdf [MB]"]
    cells = [
        [r["run"], f"{r['peak_mb']:.0f}", _seconds(r["cpu_s"]), f"{r['file_mb']:.3g}"] for r in rows
    ]
    return _table(head, cells)


def _limit(found: dict[str, Any]) -> list[str]:
    head = ["", "operations", "memory [kB]", "time [us]", "1e9 operations per second", "of peak"]
    rows = []
    for name, one in found["problems"].items():
        for what in ("evaluation", "accelerations"):
            count, seconds = sum(one["operations"][what].values()), one[f"{what}_s"]
            rate = count / seconds
            rows.append(
                [
                    f"{name}: {what}",
                    str(count),
                    f"{one['bytes'] / 1e3:.0f}",
                    f"{1e6 * seconds:.3g}",
                    f"{rate / 1e9:.2g}",
                    f"{100 * rate / found['peak']:.0f} %",
                ]
            )
        evaluations = f"{one['evaluations_per_step']:.3g} evaluations"
        step = f"{1e6 * one['radau_step_s']:.3g}"
        rows.append([f"{name}: step of radau, {evaluations}", "", "", step, "", ""])
    peak = f"{found['peak'] / 1e9:.2g}"
    rows.append(["product of two matrices of 36 x 36 (NumPy)", "93312", "31", "", peak, "100 %"])
    return _table(head, rows)


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
    whole = found["whole"]
    head = ["whole runs, radau", *(str(row["links"]) for row in whole)]
    kinds = (
        ("us_integrate", "steps, us per link and step"),
        ("us_watched", "steps and monitors, us per link and step"),
        ("ms_build", "build and start, ms per link"),
        ("ms_recover", "signals and checks, ms per link"),
        ("steps", "steps"),
    )
    return [
        *_table(["us per link and step, links:", *map(str, links)], rows),
        "",
        *_table(head, [[words, *(_number(row[key]) for row in whole)] for key, words in kinds]),
    ]


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.3g}"


def _ensemble(found: dict[str, Any]) -> list[str]:
    rows = [
        [key.replace("_", " "), f"{value:.4g}" if isinstance(value, float) else str(value)]
        for key, value in found.items()
        if not isinstance(value, list)
    ]
    return _table(["ensemble", "measured"], rows)


def machine(load: list[float] | None) -> str:
    model = platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    text = f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"
    return (
        f"{text}, load average {load[0]:.1f} before, {load[1]:.1f} after." if load else f"{text}."
    )
