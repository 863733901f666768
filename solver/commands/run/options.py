"""Arguments of the command `plymotion run`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_case_options, add_doubtful, add_figures, add_no_scripts, whole_number

EPILOG = """\
`plymotion CASE.toml` is `plymotion run CASE.toml`: it checks the case, builds its bodies in the
Python with FEniCSx, integrates its runs and writes DIR/report.html. What is up to date by content
is not done again.

Several run files are integrated in one process, or in --jobs processes, which saves the time to
start.
A run that fails does not stop the others. Each run writes result.vtkhdf and summary.json.

exit code: 0 all runs finished; 2 something is wrong with an input; 3 a run ended early, its results
up to that time are kept, or its own findings call its results invalid; 130, 143, 129 ended by
Ctrl-C, TERM or HUP, results are kept.
"""


def add_run_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `run` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "run",
        help="run a case file from check to report, or integrate run files",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="a case file, CASE.toml; or run files, build/CASE/runs/RUN.json",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="of a case: its folder (default build/CASE); of one run file: folder of its results",
    )
    parser.add_argument(
        "--jobs",
        type=whole_number,
        metavar="N",
        help="processes (default: 1 with run files, all cores with a case file)",
    )
    parser.add_argument(
        "--allow-python",
        action="store_true",
        help="run the Python functions that a case names as controllers: only of cases you trust",
    )
    add_doubtful(parser)
    parser.add_argument("--timing", action="store_true", help="print what the CPU seconds went to")
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    case = parser.add_argument_group("with a case file")
    case.add_argument(
        "--run", action="append", metavar="NAME", help="only this run; may be given several times"
    )
    case.add_argument(
        "--sweep",
        action="append",
        metavar="NAME",
        help="the members of this sweep, in place of the runs; may be given several times",
    )
    add_case_options(case)
    case.add_argument("--force", action="store_true", help="integrate runs that are up to date")
    add_no_scripts(case)
    case.add_argument("--no-report", action="store_true", help="no report.html")
    add_figures(case)
    several = parser.add_argument_group("with run files")
    several.add_argument(
        "--out-dir",
        type=Path,
        metavar="DIR",
        help="folder for a folder per run (default: build/CASE, above the run files)",
    )
    several.add_argument(
        "--update", action="store_true", help="only runs whose inputs or solver have changed"
    )
    parser.set_defaults(command=run)
