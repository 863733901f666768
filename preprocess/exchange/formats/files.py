"""Files that an import file names: they exist, and their keys are known."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....solver.errors import InputError, nearest
from ....solver.math.disk_cache import file_sha256


class Files:
    """The table `files` of an import file; paths are relative to its folder."""

    def __init__(self, table: Mapping[str, Any], folder: Path, where: str) -> None:
        self.table, self.folder, self.where = table, folder, where
        self._hashes: dict[str, str] = {}

    def only(self, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> None:
        """Raise InputError for an unknown or a missing key."""
        known = (*required, *optional)
        for key in self.table:
            if key not in known:
                raise InputError(f"{self.where}: files.{key}: unknown key{nearest(key, known)}")
        for key in required:
            if key not in self.table:
                raise InputError(
                    f"{self.where}: files.{key}: missing; expected a path; all keys: "
                    f"{', '.join(known)}"
                )

    def path(self, key: str) -> Path:
        """Path of a file that exists. Raises InputError otherwise."""
        name = self.table[key]
        if not isinstance(name, str):
            raise InputError(f"{self.where}: files.{key} = {name!r}: expected a path")
        path = self.folder / name
        if not path.is_file():
            raise InputError(f"{self.where}: files.{key} = {name!r}: no such file: {path}")
        if key not in self._hashes:
            self._hashes[key] = file_sha256(path)
        return path

    def latest(self) -> str:
        """Key and name of the file that was asked for last, for messages."""
        key = next(reversed(self._hashes), "")
        return f"files.{key} = {self.table[key]!r}" if key else "files"

    def __contains__(self, key: str) -> bool:
        return key in self.table

    def notes(self) -> dict[str, Any]:
        """Names and hashes of the files that were read, for the provenance."""
        names = {key: str(self.table[key]) for key in self._hashes}
        return {"files": names, "sha256": self._hashes}


def text_lines(path: Path) -> list[str]:
    """Lines of a text file; bytes outside ASCII come from comments only."""
    return path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
