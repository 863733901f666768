"""Arguments of the command `plymotion packages`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_no_scripts
from ..executors.choice import add_executor

EPILOG = """\
Builds the packages that run files (build/<case>/runs/<run>.json) and sweep files
(build/<case>/sweeps/<name>.json) name, each once, into the folders where runs and sweeps look for
them. Packages that are up to date are not built again.

exit code: 0 all packages are up to date; 2 wrong input; 3 some bodies could not be built, the
others were; 130 interrupted, complete packages are kept.
"""


def add_packages_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `packages` to the subcommands of an argument parser; `run` executes it."""
    parser = commands.add_parser(
        "packages",
        help="build the modal packages of runs and sweeps",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="run or sweep file")
    add_executor(parser, "bodies")
    add_no_scripts(parser)
    parser.add_argument("--quiet", action="store_true", help="print warnings and errors only")
    parser.set_defaults(command=run)
