"""CPU time and memory of `plymotion CASE` with many rigid bodies, phase by phase.

.venv/bin/python benchmarks/many_bodies.py [--write docs/speed.md] [COUNT ...]

The bodies fly freely for 1 s, with 101 output times. Everything is included: start of the program,
case file, judgement, files and report.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from shell_text import replace_between
from solver_text import machine

COUNTS = (500, 2000, 10_000)
PHASES = ("import", "load", "build", "integrate", "monitors", "recover", "write")
HEAD = ["bodies", *PHASES, "whole command", "memory"]
CASE = """
format = 1
title = "many bodies"
gravity = [0.0, 0.0, -9.81]
[bodies]
{bodies}
[signals.z]
kind = "position"
at = "b0.o"
component = "z"
[solver]
t_end = 1.0
output_step = 0.01
[runs.base]
"""
BODY = (
    'b{i} = {{ kind = "rigid", mass = 1.0, inertia = [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.25]], '
    "interfaces = {{ o = {{ position = [0, 0, 0] }} }}, position = [{i}, 0, 0], "
    "velocity = [0, 0, {speed}], angular_velocity = [1, 0.1, 0.2] }}"
)


def measured(count: int) -> list[str]:
    """A row of the table."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        bodies = "\n".join(BODY.format(i=i, speed=2.0 * i / count) for i in range(count))
        (folder / "many.toml").write_text(CASE.format(bodies=bodies), encoding="utf-8")
        words = [sys.executable, "-m", "plymotion", "many.toml", "--run", "base", "--quiet"]
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
        child = subprocess.Popen(words, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        if status:
            raise SystemExit(f"{count} bodies: the command failed")
        summary = json.loads((folder / "build/many/base/summary.json").read_text("utf-8"))
    seconds = summary["cost"]["seconds"]
    whole = usage.ru_utime + usage.ru_stime
    memory = f"{usage.ru_maxrss / 1e6:.2g} GB"
    return [str(count), *(f"{seconds[phase]:.2g}" for phase in PHASES), f"{whole:.3g}", memory]


def main() -> None:
    """Measure and print, or renew the table of a document."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("counts", nargs="*", type=int, default=COUNTS, metavar="COUNT")
    parser.add_argument("--write", type=Path, metavar="DOCUMENT")
    options = parser.parse_args()
    rows = [HEAD, ["---"] * len(HEAD), *map(measured, options.counts)]
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    print("\n".join(lines))
    if options.write:
        replace_between(options.write, "many bodies", [*lines, "", machine(None)])


if __name__ == "__main__":
    main()
