"""Arguments of the command `plymotion plan`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_no_scripts, add_packages

EPILOG = """\
The case needs [fidelity] (docs/fidelity.md). Packages that are out of date are built. The plan is
written to DIR/plans/RUN.toml, where `plymotion run` finds it.

exit code: 0 the request is met; 2 something is wrong with an input; 3 the request is not met.
"""


def add_plan_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `plan` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "plan",
        help="choose the model of a run by its accuracy",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_case_arguments(parser)
    parser.add_argument(
        "--no-check", action="store_true", help="indicators only: no run of model and check"
    )
    parser.add_argument("--json", action="store_true", help="print the answer as JSON")
    parser.set_defaults(command=run)


def add_case_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that name a run of a case."""
    parser.add_argument("case", type=Path, metavar="CASE", help="CASE.toml")
    parser.add_argument("--run", metavar="NAME", help="run of the case (default: the first)")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the case (default: build/CASE)"
    )
    add_packages(parser)
    add_no_scripts(parser)
