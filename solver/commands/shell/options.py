"""Arguments of the command `plymotion shell`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import whole_number
from ..described.options import add_command, add_out, add_shared
from ..executors.choice import add_executor

FOLDER = Path("build") / "shells"

DESCRIPTION = """\
Deflections, reactions, ply stresses and natural frequencies of laminated plates and shells. FILE
is a description (TOML, docs/shell-description.md), or a shell file (.vtkhdf) to show again.
It runs in the Python with FEniCSx: $FENICSX_PYTHON, the one that `make fenicsx` found, python3 or
/usr/bin/python3.
"""
EPILOG = """\
Writes DIR/<name>/<name>.vtkhdf, a shell file with mesh, laminates, displacements, resultants and
modes that ParaView opens, and figures beside it. Files made from the same description and sources
are not made again.

exit code: 0 done; 2 wrong input, the other FILEs are made; 130 interrupted, complete files are
kept.
"""


def add_shell_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `shell` to the subcommands of an argument parser; `run` executes it."""
    texts = {"description": DESCRIPTION, "epilog": EPILOG}
    title = "load cases and frequencies of laminated shells"
    parser = add_command(commands, "shell", run, help=title, **texts)
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="shell description or shell file"
    )
    add_out(parser, FOLDER)
    add_shared(parser, "check", "json")
    what = "draw deflected shapes and modes (default: without --json)"
    add_shared(parser, "figures", help=what)
    parser.add_argument(
        "--buckling",
        type=whole_number,
        nargs="?",
        const=4,
        metavar="COUNT",
        help="load factors of linear buckling of every load case (default 4 of each), with their "
        "errors by the mesh: a mesh of half the cell size, which doubles to quadruples the time of "
        "this step; error = false in [buckling] leaves it out",
    )
    add_shared(parser, "force", "quiet")
    add_executor(parser, "shells")
