"""Arguments of the commands `plymotion import` and `plymotion export`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

TARGETS = ("exudyn", "uff", "med", "dmig")
IMPORT = """\
Make a modal package from a body of another code. FILE (TOML, docs/exchange.md) names the files,
their units, the interfaces and the modes.
"""
EXPORT = """\
Write a modal package in the format of another code: exudyn (a script that adds the body), uff
(modes and masses), med (mesh and shapes), dmig (NASTRAN bulk data).
"""
Command = Callable[[argparse.Namespace], int]


def add_exchange_commands(commands: Any, run_import: Command, run_export: Command) -> None:
    """Add `import` and `export` to the subcommands of an argument parser."""
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
    away = commands.add_parser(
        "export", help="write a modal package in the format of another code", description=EXPORT
    )
    away.add_argument("file", type=Path, metavar="PACKAGE", help="PACKAGE.vtkhdf")
    away.add_argument("--to", dest="target", required=True, choices=TARGETS, help="the format")
    away.add_argument("--out", "-o", type=Path, help="absent: beside the package")
    away.set_defaults(command=run_export)
