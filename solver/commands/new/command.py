"""The command `plymotion new`: copy a starter case; no file is ever replaced."""

import argparse
import shlex
from pathlib import Path

from ...errors import InputError, nearest
from ...inputs.case.record import CASE_FILE
from ...package.common.temporary import write_text
from ..arguments import program
from ..case_arguments import STARTERS

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
        raise InputError(f"new {name}: no such starter{nearest(name, STARTERS)}")
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
