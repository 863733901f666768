"""The tables of docs/scale.md from the figures of scale.py."""

import re
from pathlib import Path
from statistics import median
from typing import Any

from shell_text import replace_between

LANES = [f"{name} {workers}" for name in ("local", "dask", "mpi") for workers in (1, 2)]
MILLION, NODES, CORES = 1_000_000, 100, 32
LARGEST = 100_000  # members of one sweep

Figures = dict[str, Any]


def write(figures: Figures, page: Path) -> None:
    """Renew the tables of the page."""
    replace_between(page, "measured", [*_executors(figures), "", *_large(figures)])
    replace_between(page, "million", _million(figures))


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    right = ["---", *["---:"] * (len(head) - 1)]
    return ["| " + " | ".join(cells) + " |" for cells in (head, right, *rows)]


def _repeats(figures: Figures, lane: str) -> list[Figures]:
    named = (figures.get(f"{lane} #{k}") for k in range(figures["about"]["repeats"]))
    return [figure for figure in named if figure]


def _executors(figures: Figures) -> list[str]:
    count = figures["about"]["members"]
    found = {lane: _repeats(figures, lane) for lane in LANES}
    found = {lane: repeats for lane, repeats in found.items() if repeats}
    rate = {lane: [count / f["wall_s"] for f in repeats] for lane, repeats in found.items()}
    rows = [
        ["members per second", *(f"{median(rate[lane]):.1f}" for lane in found)],
        ["each time", *(", ".join(f"{r:.1f}" for r in rate[lane]) for lane in found)],
        [
            "members per second of processor time",
            *(f"{median(count / f['cpu_s'] for f in repeats):.1f}" for repeats in found.values()),
        ],
        [
            "peak memory of one process of the command [MB]",
            *(f"{max(f['peak_mb'] for f in repeats):.0f}" for repeats in found.values()),
        ],
    ]
    head = [f"{count} members", *(f"{x}, {_workers(int(x[-1]))}" for x in found)]
    head = [re.sub(r" \d,", ",", cell) for cell in head]
    everything = [f for repeats in found.values() for f in repeats]
    loads = [f["load"] for f in everything]
    same = len({f["data"] for f in everything}) == 1
    ratio = median(
        d["wall_s"] / p["wall_s"] for d, p in zip(found["dask 2"], found["local 2"], strict=True)
    )
    return [
        *_table(head, rows),
        "",
        "Whole commands; the executors in turn. The rank of MPI that distributes and the scheduler "
        f"of dask need processors, too. dask takes {ratio:.2f} times the",
        f"wall time of local processes (two workers, median). Load of the machine before each: "
        f"{min(loads):.1f} to {max(loads):.1f}. The data of all `sweep.h5` are "
        + ("equal to the last bit" if same else "NOT EQUAL")
        + ",",
        "but for the time that each member took.",
    ]


def _workers(number: int) -> str:
    return "1 worker" if number == 1 else f"{number} workers"


def _outside(figure: Figures) -> float:
    """Wall time of a command but for the computing of members [s]."""
    told = re.search(r"computed in ([0-9.]+) s", figure["told"])
    if told is None:
        raise SystemExit(f"no time in {figure['told']!r}")
    return float(figure["wall_s"]) - float(told.group(1))


def _large(figures: Figures) -> list[str]:
    count, check, steps = figures["about"]["large"], figures["check"], figures["steps"]
    one, two = figures["first half"], figures["second half"]
    ends = [f for k in range(3) if (f := figures.get(f"finished #{k}"))]
    wall, cpu = one["wall_s"] + two["wall_s"], one["cpu_s"] + two["cpu_s"]
    lanes = steps["portions per second"]
    rows = [
        [
            "`plymotion check`: processor time, wall time, peak memory",
            f"{check['cpu_s']:.1f} s, {check['wall_s']:.1f} s, {check['peak_mb']:.0f} MB",
        ],
        ["sweep file", f"{check['file'] / 1e6:.1f} MB"],
        ["`sweep.h5`", f"{two['file'] / 1e6:.1f} MB"],
        [
            f"the sweep, 2 local processes, ended by TERM at {two['before']} members and "
            "continued: wall time, members per second",
            f"{wall:.0f} s, {count / wall:.1f}",
        ],
        ["processor time per member, all included", f"{1e3 * cpu / count:.1f} ms"],
        [
            "peak memory of one process of the command",
            f"{max(one['peak_mb'], two['peak_mb']):.0f} MB",
        ],
        [
            f"restart with {two['before']} members: wall time that is not computing",
            f"{_outside(two):.1f} s",
        ],
        [
            "restart of the finished sweep: wall time (median), processor time",
            f"{median(f['wall_s'] for f in ends):.1f} s, {median(f['cpu_s'] for f in ends):.1f} s",
        ],
        ["of it: sweep file read", f"{steps['read']:.2f} s"],
        ["members identified", f"{steps['identified']:.2f} s"],
        ["rows read and verified", f"{steps['verified']:.2f} s"],
        ["one saving of `sweep.h5`", f"{steps['saved']:.2f} s"],
        [
            f"the loop that distributes portions, for {' and for '.join(map(str, lanes))} lanes",
            " and ".join(f"{rate:,.0f}" for rate in lanes.values()) + " portions per second",
        ],
    ]
    return _table([f"{count:,} members, two parameters, two signals", ""], rows)


def _million(figures: Figures) -> list[str]:
    count, check, steps = figures["about"]["large"], figures["check"], figures["steps"]
    two = figures["second half"]
    single = median(f["cpu_s"] for f in _repeats(figures, "local 1")) / figures["about"]["members"]
    checking = check["cpu_s"] / count
    starting = (steps["read"] + steps["identified"]) / count
    saving = steps["saved"] / count
    workers = NODES * CORES
    alone = checking + starting
    rows = [
        ["computing", f"{workers / single:,.0f} members/s", f"{MILLION * single / workers:.0f} s"],
        ["`check`, one process", f"{1e3 * checking:.2f} ms per member", f"{checking * 1e6:.0f} s"],
        [
            "sweep file read and members identified, at each start of the command",
            f"{1e3 * starting:.2f} ms per member",
            f"{starting * 1e6:.0f} s",
        ],
        [
            "one saving of all rows",
            f"{1e6 * saving:.0f} us, {two['file'] / count:.0f} bytes per row",
            f"{saving * 1e6:.0f} s, {two['file'] / count * MILLION / 1e6:.0f} MB",
        ],
        [
            "time of a member below which the single processes keep 3200 workers waiting",
            f"{workers} times {1e3 * alone:.2f} ms",
            f"{workers * alone:.1f} s",
        ],
        [
            "workers that are busy all the time with these members",
            f"{1e3 * single:.0f} ms each",
            f"{single / alone:.0f}",
        ],
        [
            f"a sweep of {LARGEST:,}: check, one saving",
            "",
            f"{LARGEST * checking:.0f} s, {LARGEST * saving:.1f} s",
        ],
    ]
    return _table(
        [f"step, {workers} workers, {1e3 * single:.0f} ms per member", "rate", "1e6 members"], rows
    )
