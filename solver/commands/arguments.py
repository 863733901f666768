"""What the arguments of several subcommands share."""

import argparse


def whole_number(text: str, least: int = 1) -> int:
    """Read a whole number from `least`; argparse tells the user of anything else."""
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from {least}")
    return int(text)


def add_doubtful(parser: argparse.ArgumentParser) -> None:
    """Add --allow-doubtful to the arguments of a command that reads packages."""
    parser.add_argument(
        "--allow-doubtful",
        action="store_true",
        help="warn of packages whose numbers contradict each other (see `validate`); damaged and "
        "unusable ones are refused all the same",
    )


def add_no_scripts(parser: argparse.ArgumentParser) -> None:
    """Add --no-scripts to the arguments of a command that reads descriptions."""
    parser.add_argument(
        "--no-scripts",
        action="store_true",
        help="refuse mesh scripts (.geo, .py), which can run any command; see docs/security.md",
    )
