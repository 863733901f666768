"""Arguments of the command `plymotion chart`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..plan.options import add_case_arguments


def add_chart_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `chart` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "chart", help="draw error against CPU time of the models of a run with [fidelity]"
    )
    add_case_arguments(parser)
    parser.add_argument(
        "--figure", type=Path, metavar="PNG", help="the chart (default: DIR/plans/RUN.png)"
    )
    parser.set_defaults(command=run)
