"""Arguments of the command `plymotion sweep`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_doubtful, shard
from ..executors.choice import add_executor

EPILOG = """\
Writes DIR/sweep.h5 (docs/sweeps.md), the table DIR/sweep.csv and a figure for each signal. Members
that the same solver has computed before, with the same values and packages, are not computed again:
an interrupted sweep, or one with additional values, continues.

exit code: 0 all members finished; 2 something is wrong with the input; 3 some members stopped or
failed, the table has their messages and the others are complete; 130 interrupted, finished members
are kept.
"""

MERGE_EPILOG = """\
Writes DIR/sweep.h5, the table and the figures from DIR/sweep-k-of-N.h5, the files of
`plymotion sweep --shard k/N`, and from an earlier DIR/sweep.h5. The files of the shards stay.

exit code: 0 all members finished; 2 something is wrong with the input; 3 members are missing, or
some stopped or failed.
"""


def add_sweep_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `sweep` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "sweep",
        help="integrate the members of a sweep",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_place(parser)
    add_doubtful(parser)
    parser.add_argument(
        "--shard",
        type=shard,
        metavar="k/N",
        help="only the k-th of N shares of the members, into DIR/sweep-k-of-N.h5, see `merge`",
    )
    add_executor(parser, "members")
    again = parser.add_mutually_exclusive_group()
    again.add_argument("--fresh", action="store_true", help="compute all members again")
    again.add_argument(
        "--restart", action="store_true", help="compute missing members only (the default)"
    )
    _add_shown(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    parser.set_defaults(command=run)


def add_merge_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `merge` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "merge",
        help="merge the shards of a sweep into one file",
        epilog=MERGE_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    _add_place(parser)
    _add_shown(parser)
    parser.set_defaults(command=run)


def _add_place(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "sweep", type=Path, metavar="SWEEP", help="build/CASE/sweeps/SWEEP.json, written by check"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder (default build/CASE/sweeps/SWEEP)"
    )


def _add_shown(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--csv", action="store_true", help="print the table")
    parser.add_argument(
        "--figures",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="draw a figure for each signal (default: yes)",
    )
