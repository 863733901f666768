"""Arguments of the commands `plymotion import` and `plymotion export`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_case_options, add_no_scripts

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
    into.add_argument("file", type=Path, metavar="FILE", help="import file, TOML")
    into.add_argument(
        "--from", dest="source", metavar="CODE", help="the other code (default: its key `from`)"
    )
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
        "--out",
        "-o",
        type=Path,
        metavar="FILE",
        help="the new file (default: beside the package; of an FMU build/CASE/RUN.fmu)",
    )
    fmu = away.add_argument_group("with --to fmu")
    fmu.add_argument("--run", metavar="NAME", help="the run (default: the only one of the case)")
    fmu.add_argument(
        "--inputs",
        nargs="*",
        metavar="KEY",
        help="drives and forces that are inputs, such as joints.hinge.drive (default: all); the "
        "others follow their laws in the case",
    )
    add_case_options(fmu)
    add_no_scripts(fmu)
    away.set_defaults(command=run_export)
