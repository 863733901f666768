"""A folder that `check` writes: which files in it are its own, and no others.

manifest.json lists them. It is written before the first file and after the last one is gone, so
that a `check` that was killed leaves no file that it does not know.
"""

import hashlib
import json
import re
from pathlib import Path

from ...errors import InputError
from ...package.common.temporary import temporary_sibling, write_text

MANIFEST, WRITER = "manifest.json", "plymotion check"
RULES_HEAD = "# Written by `python -m plymotion.solver check`; do not edit."
# What a manifest may name: anything else in it was written by somebody else.
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
        self._links: dict[str, Path] = {}
        self._made: dict[str, None] = {}  # by other programs, from these files

    def add(self, name: str, text: str, *made: str) -> None:
        """Want a file; `made` are names of files that other programs make from it."""
        self._texts[name] = text
        self._made |= dict.fromkeys(made)

    def link(self, target: Path) -> str:
        """Want a link to a file outside; return its name, plain whatever the file is called."""
        target = target.parent.resolve() / target.name
        digest = hashlib.sha256(str(target).encode("utf-8", "surrogateescape")).hexdigest()
        name = f"inputs/{digest[:16]}"
        self._links[name] = target
        return name

    def write(self, last: tuple[str, str]) -> None:
        """Write all files, remove those of an earlier `check`, and write `last`.

        Raises
        ------
        InputError
            The folder has a file of the same name that `check` has not written.
        """
        before, adopted = self._before()
        wanted = [*self._texts, *self._links, last[0], MANIFEST]
        for name in wanted:
            file = self.path / name
            there = file.is_symlink() or file.exists()
            if there and name not in before and not adopted:
                raise InputError(
                    f"--out {self.path}: {name} is there already and was not written by `check`; "
                    "expected a new folder, or the build folder of a case"
                )
        made = [n for n in self._made if n in before or adopted or not (self.path / n).exists()]
        own = [*wanted, *made]
        self._record([*before, *own])
        for name, text in self._texts.items():
            write_if_changed(self.path / name, text)
        for name, target in self._links.items():
            _link(self.path / name, target)
        for name in before - set(own):
            (self.path / name).unlink(missing_ok=True)
        self._record(own)
        # Make takes its time as that of `check`: always newer than the case file.
        write_text(self.path / last[0], last[1])

    def _before(self) -> tuple[set[str], bool]:
        """Return the own files of an earlier `check`; whether one without manifest was here."""
        try:
            table = json.loads((self.path / MANIFEST).read_text(encoding="utf-8"))
            if table["written_by"] == WRITER:
                own = {n for n in table["files"] if isinstance(n, str) and _is_own(n)}
                return {MANIFEST, *own}, False
            return set(), False
        except (OSError, ValueError, KeyError, TypeError):  # none, or none of ours
            rules = self.path / "case.mk"
            head = rules.read_bytes()[: len(RULES_HEAD)] if rules.is_file() else b""
            return set(), head == RULES_HEAD.encode()

    def _record(self, names: list[str]) -> None:
        table = {"written_by": WRITER, "files": sorted(set(names))}
        write_if_changed(self.path / MANIFEST, json.dumps(table, indent=1) + "\n")


def _is_own(name: str) -> bool:
    return _OWN.fullmatch(name) is not None and not name.endswith(("/.", "/.."))


def _link(file: Path, target: Path) -> None:
    if file.is_symlink() and file.readlink() == target:
        return
    file.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(file) as temporary:
        temporary.symlink_to(target)


def write_if_changed(file: Path, text: str) -> None:
    """Write a file unless it already holds `text`."""
    raw = text.encode("utf-8")
    if not (file.is_file() and file.read_bytes() == raw):
        write_text(file, text)
