"""The command line: all commands, in the order in which a user meets them."""

import argparse
import gc
from contextlib import closing, nullcontext
from importlib import import_module
from typing import Any

from plymotion import __version__

from ..system.interrupts import starting
from . import body_arguments as bodies
from . import case_arguments as cases
from .arguments import COMMAND, CommandParser, HelpText, command, flag
from .heartbeat import Heartbeat

EPILOG = """\
examples:
  plymotion new robot-arm                 a commented case, robot-arm/case.toml
  plymotion robot-arm/case.toml           check, bodies, runs: build/robot-arm/report.html
  plymotion CASE.toml --sweep NAME        many runs of a case; other options: plymotion run --help

exit code: 0 done; 2 something is wrong with the input; 3 a run or a member of a sweep ended early
or is invalid, see the help of the command; 70 a defect of the program; 130, 143, 129 ended by
Ctrl-C, TERM or HUP.
"""


@command("compile", "setup:run_compile")
def add_compile(parser: Any) -> None:
    """Compile before the first run, which is then as fast as later ones."""
    flag(parser, "all", "also for generalized-alpha, and what FEniCSx needs to build bodies")


@command("schema", "setup:run_schema")
def add_schema(parser: Any) -> None:
    """Print the JSON schema of a file, by which editors complete and check it."""
    kinds = ["case", "section", "shell", "solid"]
    parser.add_argument(
        "kind", nargs="?", choices=kinds, default="case", help="of a file (default: case)"
    )


@command("materials", "setup:run_materials")
def add_materials(parser: Any) -> None:
    """List the materials of the library with their sources, or print one for a file."""
    parser.add_argument("name", nargs="?", help="of a material: prints its table in TOML")


@command("completion", "setup:run_completion")
def add_completion(parser: Any) -> None:
    """Print the completion of commands and options for a shell."""
    parser.add_argument("shell", choices=["bash", "zsh"], help="see docs/runs.md")


# A case, its parts, bodies of other codes, studies of a case, steps of `run`, the rest.
COMMANDS = (
    *(cases.add_new, cases.add_check, cases.add_run, cases.add_report, cases.add_modes),
    *(bodies.add_section, bodies.add_shell, bodies.add_solid, add_materials, bodies.add_blade),
    *(bodies.add_import, bodies.add_export, bodies.add_info),
    *(cases.add_optimise, cases.add_plan, cases.add_sensitivities),
    *(cases.add_packages_command, cases.add_sweep),
    *(add_compile, add_schema, add_completion),
)


# Commands that say little while they work.
WITH_HEARTBEAT = ("modes", "optimise", "plan", "sensitivities", "export")
NAMES = [add.__name__ for add in COMMANDS]


def parser(name: str = "") -> CommandParser:
    """Return the parser of all commands, or of the one that the name says: 10 ms less."""
    parser = CommandParser(
        prog="plymotion",
        usage="plymotion CASE.toml | plymotion COMMAND ...",
        description="Flexible multibody dynamics with laminated members.\n"
        "`plymotion CASE.toml` goes from a case file to its report; commands do parts of it.",
        epilog=EPILOG,
        formatter_class=HelpText,
    )
    parser.add_argument("--version", action="version", version=f"plymotion {__version__}")
    commands = parser.add_subparsers(required=True, metavar=COMMAND, prog="plymotion")
    for add in COMMANDS:
        if name not in NAMES or add.__name__ == name:
            add(commands)
    return parser


def run_command(options: argparse.Namespace) -> int:
    """Import the function of a command and call it; return the exit code."""
    module, name = options.command.split(":")
    gc.disable()  # collection during imports costs time and frees nothing
    try:
        with starting():
            import platform  # not for --help

            # h5py asks for it when it is imported: another process would be started, 5 ms
            vars(platform.uname())["processor"] = ""
            function = getattr(import_module(f".{module}", __package__), name)
    finally:
        gc.enable()
    beats = name.removeprefix("run_") in WITH_HEARTBEAT and not getattr(options, "quiet", False)
    with closing(Heartbeat(name.removeprefix("run_"))) if beats else nullcontext():
        return int(function(options))
