"""Arguments of the commands `plymotion import` and `plymotion export`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_no_scripts

TARGETS = ("exudyn", "uff", "med", "dmig", "mbdyn", "sid", "fmu")
IMPORT = """\
Make a modal package from a body of another code. FILE (TOML, docs/exchange.md) names the files,
their units, the interfaces and the modes.
"""
EXPORT = """\
Write a modal package in the format of another code: exudyn (a script that adds the body), uff
(modes and masses), med (mesh and shapes), dmig (NASTRAN bulk data), mbdyn (.fem of the modal
joint), sid (standard input data). Or write a run of a case as an FMU for co-simulation (fmu).
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
    away.add_argument(
        "file", type=Path, metavar="FILE", help="PACKAGE.vtkhdf; with --to fmu CASE.toml"
    )
    away.add_argument("--to", dest="target", required=True, choices=TARGETS, help="the format")
    away.add_argument(
        "--out", "-o", type=Path, help="absent: beside the package; build/<case>/<run>.fmu"
    )
    fmu = away.add_argument_group("with --to fmu")
    fmu.add_argument("--run", metavar="NAME", help="the run; absent: the only one of the case")
    fmu.add_argument(
        "--inputs",
        nargs="*",
        metavar="KEY",
        help="drives and forces that are inputs, such as joints.hinge.drive; absent: all. The "
        "others follow their laws in the case",
    )
    fmu.add_argument("--coarse", action="store_true", help="apply the [coarse] variant")
    fmu.add_argument(
        "--packages", type=Path, metavar="DIR", help="ready packages: FEniCSx is not needed"
    )
    add_no_scripts(fmu)
    away.set_defaults(command=run_export)
