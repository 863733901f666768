"""Run cases in their coarse version and their sweeps; a second time there must be nothing to do.

    all_cases.py CASE|CASE-sweep-NAME ...

One process runs them, as `make CASE COARSE=1` would one after the other: it loads the program and
FEniCSx once, which takes longer than most of these runs. The exit code is 1 if a command fails or
does something again. Code 3 of a command is none: a run ended early, its results are reported.
"""

import contextlib
import gc
import io
import sys
from collections.abc import Iterable

from plymotion.solver.__main__ import main
from plymotion.solver.workers.launch import kept_preprocessors


def command(name: str) -> list[str]:
    """The command of a target of the Makefile."""
    case, _, sweep = name.partition("-sweep-")
    of_sweep = ["--sweep", sweep] if sweep else []
    return [f"cases/{case}/case.toml", *of_sweep, "--coarse", "--jobs", "1"]


def failures(names: Iterable[str]) -> list[str]:
    """Those whose command fails."""
    return [name for name in names if main(command(name)) not in (0, 3)]


def run(names: list[str]) -> int:
    """Run all of them twice; the exit code."""
    gc.freeze()
    gc.set_threshold(50_000)  # as in a process of a command
    with kept_preprocessors():
        failed = failures(names)
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            failed += failures(names)
    again = [line for line in printed.getvalue().splitlines() if not line.endswith(": up to date")]
    for line in (*again, *(f"{name}: failed" for name in failed)):
        print(f"error: {line}", file=sys.stderr)
    return int(bool(failed or again))


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
