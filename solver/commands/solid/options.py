"""Arguments of the command `plymotion solid`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..described.options import add_command, add_out, add_shared
from ..executors.choice import add_executor

FOLDER = Path("build") / "solids"

DESCRIPTION = """\
Mass, inertia, natural frequencies and load cases of solids. FILE is a CAD file (STEP, IGES), a
description (TOML, docs/solids.md), or a package that this command made (.vtkhdf) to show again.
It runs in the Python with FEniCSx: $FENICSX_PYTHON, the one that `make fenicsx` found, python3 or
/usr/bin/python3.
"""
EPILOG = """\
Writes DIR/<name>/<name>.vtkhdf, the modal package of the free solid: ParaView opens it, and a case
takes it with kind = "package". Files made from the same description and sources are not made
again.

exit code: 0 done; 2 wrong input, the other FILEs are made; 130 interrupted, complete files are
kept.
"""


def add_solid_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `solid` to the subcommands of an argument parser; `run` executes it."""
    texts = {"description": DESCRIPTION, "epilog": EPILOG}
    title = "inertia, frequencies and load cases of solids from CAD"
    parser = add_command(commands, "solid", run, help=title, **texts)
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="CAD file, description or package"
    )
    parser.add_argument(
        "--material",
        metavar="NAME|E,nu,rho",
        help="of a CAD file: aluminium, steel, titanium, or constants in Pa and kg/m3",
    )
    parser.add_argument(
        "--size", type=float, metavar="M", help="of the cells [m] (default: see docs/solids.md)"
    )
    add_out(parser, FOLDER)
    add_shared(parser, "check", "json", "force", "quiet")
    add_executor(parser, "solids")
