"""Arguments that the commands `section` and `shell` share."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..arguments import add_no_scripts

_SHARED: dict[str, dict[str, Any]] = {
    "out": {"type": Path, "metavar": "DIR"},
    "check": {
        "action": "store_true",
        "help": "check descriptions, write DIR/<name>/<name>.json only",
    },
    "json": {"action": "store_true", "help": "numbers as JSON on standard output"},
    "figures": {"action": argparse.BooleanOptionalAction},
    "force": {"action": "store_true", "help": "repeat also what has not changed"},
    "quiet": {"action": "store_true", "help": "no progress"},
}


def add_shared(group: Any, *names: str, **more: Any) -> None:
    """Add shared options to a parser or a group of it; `more` goes to all of them."""
    for name in names:
        group.add_argument(f"--{name}", **_SHARED[name], **more)


def add_out(group: Any, folder: Path) -> None:
    """Add the option --out; without it None, as a folder that the user has named may be a link."""
    add_shared(group, "out", help=f"folder (default {folder})")


def add_command(
    commands: Any, name: str, run: Callable[[argparse.Namespace], int], **texts: str
) -> Any:
    """Add a subcommand to an argument parser; `texts` are its help, description and epilog."""
    formatter = argparse.RawDescriptionHelpFormatter
    parser = commands.add_parser(name, formatter_class=formatter, **texts)
    parser.set_defaults(command=run)
    add_no_scripts(parser)
    return parser
