"""Arguments of the command `plymotion shell`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

FOLDER = Path("build") / "shells"

DESCRIPTION = """\
Deflections, reactions, ply stresses and natural frequencies of laminated plates and shells. FILE
describes one (TOML, docs/shell-description.md), or is a shell file (.vtkhdf) to show again.
FEniCSx is looked for in $FENICSX_PYTHON, where `make fenicsx` found it, python3 and
/usr/bin/python3.
"""
EPILOG = """\
Writes DIR/<name>/<name>.vtkhdf, a shell file with mesh, laminates, displacements, resultants and
modes that ParaView opens, and figures beside it. What is there and was made from the same
description and sources is not made again.

exit code: 0 done; 2 something is wrong with the input, the other FILEs are made; 130 interrupted,
what is complete is kept.
"""


def add_shell_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `shell` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "shell",
        help="load cases and frequencies of laminated shells",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="shell description or shell file"
    )
    parser.add_argument(
        "--out", type=Path, default=FOLDER, metavar="DIR", help=f"folder (default {FOLDER})"
    )
    parser.add_argument(
        "--check", action="store_true", help="check descriptions, write DIR/<name>/<name>.json only"
    )
    parser.add_argument("--json", action="store_true", help="numbers as JSON on standard output")
    parser.add_argument(
        "--figures",
        action=argparse.BooleanOptionalAction,
        help="draw deflected shapes and modes (default: without --json)",
    )
    parser.add_argument("--force", action="store_true", help="make also what has not changed")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.set_defaults(command=run)
