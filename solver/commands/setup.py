"""The commands that need no case: `new`, `compile`, `materials`, `schema`, `completion`."""

import argparse
import shlex
from collections.abc import Iterator
from pathlib import Path

from ..errors import InputError, nearest
from ..inputs.case.record import CASE_FILE
from ..package.common.files import write_text
from .arguments import program
from .case_arguments import STARTERS

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
            "completion: shtab is not installed; expected `pip install shtab`"
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


def run_compile(options: argparse.Namespace) -> int:
    """Compile the step loop; with --all also what other methods and FEniCSx need."""
    from ..studies.compiling import compile_ahead
    from ..workers.launch import compile_forms

    print(compile_ahead(everything=options.all), flush=True)
    if options.all:
        print(compile_forms())
    return 0


def run_schema(options: argparse.Namespace) -> int:
    """Print the JSON schema of a kind of file."""
    from ..inputs.json_schema import json_schema
    from ..report.table import json_text

    print(json_text(json_schema(options.kind)))
    return 0


def run_materials(options: argparse.Namespace) -> int:
    """List the library of materials, or print one as TOML. Raises InputError for another name."""
    from ..inputs.common.published_materials import LIBRARY
    from ..package.common.plain_data import toml_text

    if options.name is None:
        for name, entry in LIBRARY.items():
            print(f"{name:14s} {entry.meaning}: {entry.source}")
        print('in a file: [materials] with NAME = "al-6061-t6", or library = "..." in a table')
        return 0
    if options.name not in LIBRARY:
        raise InputError(
            f"materials {options.name}: no such material{nearest(options.name, LIBRARY)}"
        )
    entry = LIBRARY[options.name]
    print(f"# {entry.meaning}: {entry.source}\n[materials.{options.name}]")
    print(toml_text(entry.table, f"materials.{options.name}."), end="")
    return 0


HOME = Path(__file__).parent / "starters"


def run_new(options: argparse.Namespace) -> int:
    """Write a starter case; return the exit code.

    Raises
    ------
    InputError
        No such starter; a folder that has files already.
    """
    name: str = options.starter
    if name not in STARTERS:
        raise InputError(f"new {name}: no such starter{nearest(name, STARTERS, len(STARTERS))}")
    folder: Path = options.folder or Path(name)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: expected a new folder, found a file")
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError(f"{folder}: expected a new or empty folder; nothing is replaced")
    for source in sorted((HOME / name).iterdir()):
        write_text(folder / source.name, source.read_text(encoding="utf-8"), own=True)
    file = folder / CASE_FILE
    print(f"{file}: {STARTERS[name]}\nNext: {program()} {shlex.quote(str(file))}")
    return 0
