"""Which files the commands may replace, and which folders they write into; one rule for all.

A file that is there is replaced if it is empty, ends in the seal of our HDF5 files, or its folder's
`plymotion-files.txt` names it. Links below a folder that the user named are not followed if they
lead out of it. docs/security.md has the rule in words.
"""

import contextlib
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from ...errors import InputError
from .disk_file import LENGTH, SEAL

RECORD = "plymotion-files.txt"
HEAD, SIGNATURE = 1_000_000, b"\x89HDF\r\n\x1a\n"
SEALED = (".vtkhdf", ".h5")
_named: tuple[Path, ...] = ()  # folders, absolute but not resolved


@contextlib.contextmanager
def named_by_user(paths: Iterable[Path]) -> Iterator[None]:
    """Take the folders of these paths, and `build` here, as they are: links above are the user's.

    Other paths of the block are checked as far as they are below one of them.
    """
    global _named
    known = {Path(os.path.abspath(path)) for path in (*paths, Path("build"))}
    before, _named = _named, tuple(known | {p for path in known for p in path.parents})
    try:
        yield
    finally:
        _named = before


def refuse_foreign(path: Path) -> None:
    """Raise InputError if a file may not be written here.

    Raises
    ------
    InputError
        It would replace a file that is not ours, or its folder is a link that leads elsewhere.
    """
    refuse_link(path)
    if os.path.lexists(path) and not is_ours(path):
        raise InputError(
            f"{path}: is there already and was not written by Plymotion, which does not replace "
            "it; expected another name or folder, or that you remove the file"
        )


def note_written(path: Path) -> None:
    """Record a file as ours, before it gets its name; sealed ones need no record."""
    if path.suffix in SEALED or path.name in _names(path.parent):
        return
    record = path.parent / RECORD
    head = "" if record.exists() else "# Files that Plymotion has written here, and may replace.\n"
    with record.open("a", encoding="utf-8") as file:
        file.write(f"{head}{json.dumps(path.name)}\n")


def is_ours(path: Path) -> bool:
    """Tell whether a file that is there may be replaced or removed."""
    if path.is_symlink() or not path.is_file():
        return False
    return (
        path.stat().st_size == 0
        or (path.suffix in SEALED and _is_sealed(path))
        or path.name in _names(path.parent)
    )


def _names(folder: Path) -> set[str]:
    try:
        lines = (folder / RECORD).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return set()
    return {json.loads(line) for line in lines if line.startswith('"') and line.endswith('"')}


def _is_sealed(path: Path) -> bool:
    """Tell whether a file is HDF5 of ours, also one that was cut off."""
    with path.open("rb") as file:
        head = file.read(HEAD)
        file.seek(-min(path.stat().st_size, LENGTH), os.SEEK_END)
        return SEAL in file.read() or (head.startswith(SIGNATURE) and b"plymotion" in head)


def refuse_link(path: Path) -> None:
    """Raise InputError if the folder of a file is a link that leads out of what the user named."""
    folder = Path(os.path.abspath(path)).parent
    roots = [root for root in (folder, *folder.parents) if root in _named]
    if not roots:
        return
    root = roots[0]  # the deepest
    inside = os.path.realpath(root)
    while folder != root:
        target = os.path.realpath(folder)
        if folder.is_symlink() and not Path(target).is_relative_to(inside):
            raise InputError(
                f"{path}: {folder} is a link to {target}, out of {root}: not followed; "
                f"expected a folder, or --out {target} if you want the files there"
            )
        folder = folder.parent
