"""Arguments of the command `plymotion new`."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Starter cases: the folders of starters/, and what each shows.
STARTERS = {
    "arm": "a driven laminated link with a payload",
    "robot-arm": "two laminated tubes with two drives, torques and ply strength",
    "panel": "a laminated plate (shell) on a turning hub",
    "bracket": "a part from CAD (STEP) that turns a payload",
    "pendulum": "a laminated bar on a hinge, set swinging",
    "blade": "a rotating composite blade, stiffened by its spin",
}
EPILOG = "starters:\n" + "\n".join(f"  {name:10} {text}" for name, text in STARTERS.items())


def add_new_command(commands: Any, run: Callable[[argparse.Namespace], int]) -> None:
    """Add `new` to the subcommands of an argument parser; `run` is what it does."""
    parser = commands.add_parser(
        "new",
        help="write a starter case, which runs as it is",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("starter", metavar=f"{{{','.join(STARTERS)}}}", help="see below")
    parser.add_argument(
        "folder",
        type=Path,
        nargs="?",
        metavar="DIR",
        help="new folder of the case (default: named like the starter)",
    )
    parser.set_defaults(command=run)
