"""A folder that `check` writes: which files in it are its own, and no others.

manifest.json lists them. It is written before the first file and after the last one is gone, so
that a `check` that was killed leaves no file that it does not know.
"""

import json
import re
from pathlib import Path
from typing import Any

from ....errors import InputError
from ....package.common.replaceable import refuse_link
from ....package.common.temporary import write_text

MANIFEST, CASE, WRITER = "manifest.json", "case.json", "plymotion check"
# What a manifest may name: anything else in it was written by somebody else. Earlier versions
# wrote rules for make and links to inputs, which are removed.
_OWN = re.compile(r"case\.json|case\.mk|((sweeps/)?bodies|runs|sweeps|inputs)/[A-Za-z0-9_.-]+")


class OutputFolder:
    """The files that `check` wants in a folder; nothing is written before `write`.

    Attributes
    ----------
    path : the folder
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._texts: dict[str, str] = {}
        self._made: dict[str, None] = {}  # by other programs, from these files
        self._kept: tuple[str, ...] = ()  # beginnings of names

    def add(self, name: str, text: str, *made: str) -> None:
        """Want a file; `made` are names of files that other programs make from it."""
        self._texts[name] = text
        self._made |= dict.fromkeys(made)

    def keep(self, *beginnings: str) -> None:
        """Leave files of an earlier `check` whose names begin so as they are."""
        self._kept += beginnings

    def write(self) -> None:
        """Write all files and remove those of an earlier `check` that are not wanted or kept.

        Raises
        ------
        InputError
            The folder has a file of the same name that `check` has not written.
        """
        for name in (*self._texts, MANIFEST):
            refuse_link(self.path / name)
        before, adopted = self._before()
        wanted = [*self._texts, MANIFEST]
        for name in () if adopted else wanted:
            if name not in before and self._would_be_lost(name):
                raise InputError(
                    f"--out {self.path}: {name} is there already and was not written by `check`; "
                    "expected a new folder, or the build folder of a case"
                )
        made = [n for n in self._made if n in before or adopted or not (self.path / n).exists()]
        kept = [name for name in before if name.startswith(self._kept)]
        own = [*wanted, *made, *kept]
        self._record([*before, *own])
        for name, text in self._texts.items():
            write_if_changed(self.path / name, text)
        for name in before - set(own):
            (self.path / name).unlink(missing_ok=True)
        self._record(own)

    def _would_be_lost(self, name: str) -> bool:
        """Tell whether a file has content that `write` would replace by another one."""
        file = self.path / name
        if not file.is_file():
            return file.is_symlink() or file.exists()
        return file.read_bytes() not in (b"", self._texts.get(name, "").encode())

    def _before(self) -> tuple[set[str], bool]:
        """Return the own files of an earlier `check`; whether one without manifest was here."""
        table = _read(self.path / MANIFEST)
        if table.get("written_by") == WRITER and isinstance(table.get("files"), list):
            own = {n for n in table["files"] if isinstance(n, str) and _is_own(n)}
            return {MANIFEST, *own}, False
        return set(), _read(self.path / CASE).get("written_by") == WRITER

    def _record(self, names: list[str]) -> None:
        table = {"written_by": WRITER, "files": sorted(set(names))}
        write_if_changed(self.path / MANIFEST, json.dumps(table, indent=1) + "\n")


def _is_own(name: str) -> bool:
    return _OWN.fullmatch(name) is not None and not name.endswith(("/.", "/.."))


def _read(file: Path) -> dict[str, Any]:
    """Return a table of a JSON file; an empty one of any other file."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def write_if_changed(file: Path, text: str) -> None:
    """Write a file unless it already holds `text`."""
    raw = text.encode("utf-8")
    if not (file.is_file() and file.read_bytes() == raw):
        write_text(file, text, own=True)
