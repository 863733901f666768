"""Arguments of the commands `plymotion import` and `plymotion export`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

IMPORT = """\
Make a modal package from a body of another code. FILE (TOML, docs/exchange.md) names the files,
their units, the interfaces and the modes.
"""
Command = Callable[[argparse.Namespace], int]


def add_exchange_commands(commands: Any, run_import: Command) -> None:
    """Add `import` to the subcommands of an argument parser."""
    into = commands.add_parser(
        "import", help="make a modal package from a body of another code", description=IMPORT
    )
    into.add_argument("file", type=Path, metavar="FILE", help="import file")
    into.add_argument("--from", dest="source", metavar="CODE", help="instead of its key `from`")
    into.add_argument(
        "--out", "-o", type=Path, required=True, metavar="PACKAGE", help="PACKAGE.vtkhdf"
    )
    into.add_argument("--quiet", action="store_true", help="no progress")
    into.set_defaults(command=run_import)
