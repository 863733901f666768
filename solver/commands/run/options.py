"""Arguments of the command `plymotion run`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_doubtful, whole_number

EPILOG = """\
Several FILEs are integrated in one process, or in --jobs processes, which saves the time to start.
A run that fails does not stop the others. Each leaves result.vtkhdf and summary.json.

exit code: 0 all runs finished; 2 something is wrong with an input; 3 a run ended early, its results
up to that time are kept; 130, 143, 129 ended by Ctrl-C, TERM or HUP, results are kept.
"""


def add_run_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `run` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "run",
        help="integrate runs",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "runs",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="build/<case>/runs/<run>.json, written by check",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results of one run")
    parser.add_argument(
        "--out-dir",
        type=Path,
        metavar="DIR",
        help="folder for a folder per run (default: build/<case>, above the run files)",
    )
    parser.add_argument(
        "--jobs", type=whole_number, default=1, metavar="N", help="processes (default 1)"
    )
    parser.add_argument(
        "--update", action="store_true", help="only runs whose inputs or solver have changed"
    )
    add_doubtful(parser)
    parser.add_argument("--timing", action="store_true", help="print what the CPU seconds went to")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    parser.set_defaults(command=run)
