"""The command `plymotion completion`: a script that completes commands and options in a shell."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from ..errors import InputError

FILES = {"bash": "_shtab_compgen_files", "zsh": "_files"}


def run_completion(options: argparse.Namespace) -> int:
    """Print the completion for a shell."""
    from .parser import parser

    print(completion(parser(), options.shell))
    return 0


def completion(parser: argparse.ArgumentParser, shell: str) -> str:
    """Return the script for a shell, "bash" or "zsh". Raises InputError without shtab."""
    try:
        import shtab
    except ImportError as error:
        raise InputError(
            "completion: shtab is not installed; expected the extra `completion`: "
            "pip install plymotion[completion]"
        ) from error
    for action in _actions(parser):
        if action.type is Path:
            action.complete = FILES  # type: ignore[attr-defined]
    return str(shtab.complete(parser, shell))


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
