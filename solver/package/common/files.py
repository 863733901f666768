"""Files on a disk: temporary names, what may be replaced, errors of the disk, and a seal.

A file gets its name when it is complete. The commands replace a file that is empty, ends in the
seal of our HDF5 files, or is named by `plymotion-files.txt` in its folder. Links below a folder
that the user named are not followed if they lead out of it; docs/security.md has the rule in words.

HDF5 cannot be stopped in the middle of a file: an error of the disk while it writes may end the
whole program. It therefore writes through an object that notes the first error and accepts the
rest; the error is raised when HDF5 has closed the file. Signals wait for calls of this object.

The seal is a line after the end of the HDF5 file, which HDF5 ignores: reading a file with a wrong
byte may end the program as well. HDF5 removes it when it opens the file for changes.
"""

import contextlib
import errno
import hashlib
import io
import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from ...errors import InputError
from ...system.interrupts import note_complete, uninterrupted
from ...system.platform import has_ended, host

SEAL = b"\nplymotion sha256 "
LENGTH = len(SEAL) + 64 + 1
BLOCK = 1 << 20
KEPT = 1 << 16  # size in bytes up to which blocks without room are kept, for HDF5 to read again


class DiskFile(io.FileIO):
    """A new file that HDF5 writes through; use it as a context."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.path = path
        self._end = 0  # with what the disk has not taken
        self._error: OSError | None = None
        self._kept: list[tuple[int, bytes]] = []

    @uninterrupted
    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the place of the next read or write."""
        if whence == os.SEEK_END:
            offset, whence = offset + self._end, os.SEEK_SET
        return super().seek(offset, whence)

    @uninterrupted
    def readinto(self, buffer: "bytearray | memoryview") -> int:  # type: ignore[override]
        """Read what was written, on the disk or not."""
        place, view = self.tell(), memoryview(buffer).cast("B")
        count = super().readinto(view)
        view[count:] = bytes(len(view) - count)
        for start, block in self._kept:
            first, last = max(start, place), min(start + len(block), place + len(view))
            if first < last:
                view[first - place : last - place] = block[first - start : last - start]
        self.seek(place + len(view))
        return len(view)

    @uninterrupted
    def write(self, data: "bytes | memoryview") -> int:  # type: ignore[override]
        """Write; an error of the disk is noted."""
        place, raw, done = self.tell(), memoryview(data).cast("B"), 0
        try:
            while self._error is None and done < len(raw):
                done += super().write(raw[done:])
        except OSError as error:
            self._error = error
        if self._error is not None and len(raw) - done <= KEPT:
            self._kept.append((place + done, bytes(raw[done:])))
        self._end = max(self._end, self.seek(place + len(raw)))
        return len(raw)

    @uninterrupted
    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        self._end = self.tell() if size is None else size
        if self._error is None:
            try:
                super().truncate(self._end)
            except OSError as error:
                self._error = error
        return self._end

    @contextlib.contextmanager
    def reported(self) -> Iterator[None]:
        """Raise the first error of the disk in place of what follows from it."""
        try:
            yield
        except Exception:
            self._raise()
            raise
        self._raise()

    def seal(self) -> None:
        """Append the digest of all bytes."""
        digest = hashlib.sha256()
        self.seek(0)
        while block := self.read(BLOCK):
            digest.update(block)
        self.seek(0, os.SEEK_END)
        self.write(SEAL + digest.hexdigest().encode() + b"\n")
        self._raise()

    def _raise(self) -> None:
        if self._error is None:
            return
        code = self._error.errno or errno.EIO
        message = f"{os.strerror(code)}; the file needs {self._end + LENGTH} bytes"
        with contextlib.suppress(OSError, AttributeError):
            import shutil  # not for a command that writes well

            free = shutil.disk_usage(self.path.parent).free + self.path.stat().st_size
            message += f", {free} are free"
        raise OSError(code, message, str(self.path)) from self._error


def has_right_seal(path: Path) -> bool:
    """Return whether a file is there, and whole to the last byte."""
    try:
        with path.open("rb") as file:
            return _ends_with_seal(file) and sealed_bytes(file)
    except OSError:
        return False


def has_seal(path: Path) -> bool:
    """Return whether a file ends with a seal, right or wrong: `sealed_bytes` compares it."""
    with path.open("rb") as file:
        return _ends_with_seal(file)


def check_seal(path: Path, error: type[Exception]) -> None:
    """Raise `error` for a file without a seal; `open_file` has compared the bytes of others."""
    if not has_seal(path):
        raise error(
            f"{path}: content was altered after writing, or is incomplete: expected a seal at the "
            "end of the file (docs/format.md)"
        )


def _ends_with_seal(file: BinaryIO) -> bool:
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - LENGTH, 0))
    return file.read(len(SEAL)) == SEAL


def sealed_bytes(file: BinaryIO) -> bool:
    """Return whether all bytes of a file are as they were written; true for one without a seal."""
    size = file.seek(0, os.SEEK_END)
    if size < LENGTH:
        return True
    file.seek(size - LENGTH)
    content = file.read()
    if not content.startswith(SEAL):
        return not _is_cut(file, size)
    digest, left = hashlib.sha256(), size - LENGTH
    file.seek(0)
    while left:
        block = file.read(min(BLOCK, left))
        digest.update(block)
        left -= len(block)
    return content == SEAL + digest.hexdigest().encode() + b"\n"


def _is_cut(file: BinaryIO, size: int) -> bool:
    """Return whether a file ends within its seal."""
    file.seek(0)
    head = file.read(64)
    # Where the superblock has the end of the HDF5 file: 8 bytes, by its version.
    place = {0: 40, 1: 44, 2: 28, 3: 28}.get(head[8] if len(head) == 64 else -1)
    if place is None:
        return False
    end = int.from_bytes(head[place : place + 8], "little")
    if not end < size < end + LENGTH:
        return False
    file.seek(end)
    return SEAL.startswith(file.read(len(SEAL)))


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
            f"{path}: already exists and was not written by Plymotion, which does not replace "
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
    """Return whether a file that is there may be replaced or removed."""
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
    """Return whether a file is HDF5 of ours, also one that was cut off."""
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


_HOST = re.sub(r"[^A-Za-z0-9]", "_", host()) or "_"
_OURS = re.compile(rf"\..+\.{_HOST}-(\d+)-[0-9a-f]{{8}}(\.[^.]*)?")
_cleaned: set[Path] = set()  # folders, by this process


@contextlib.contextmanager
def temporary_sibling(path: Path, *, own: bool = False) -> Iterator[Path]:
    """Yield a temporary name beside `path`; rename it to `path` on success, remove it on failure.

    Temporary files in the folder whose process was killed are removed. Raises OSError with `path`,
    and InputError for a file of others (`refuse_foreign`); `own` says that the caller has looked.
    """
    if not own:
        refuse_foreign(path)
    _clean(path.parent)
    token = f"{_HOST}-{os.getpid()}-{os.urandom(4).hex()}"
    temporary = path.with_name(f".{path.stem}.{token}{path.suffix}")
    try:
        yield temporary
        if not own:
            note_written(path)
        os.replace(temporary, path)
        note_complete(str(path))
    except OSError as error:
        if error.filename is not None and Path(os.fsdecode(error.filename)) == temporary:
            raise OSError(error.errno, error.strerror, str(path)) from error
        if error.filename is None and error.errno is not None:
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str, *, own: bool = False, encoding: str = "utf-8") -> None:
    """Write a text file under a temporary name, then rename it; its folder is made if missing.

    ASCII gets ? for other letters. See `temporary_sibling`.

    Parameters
    ----------
    path : the file
    text : its text
    own : the caller has checked that the file may be replaced (`refuse_foreign`)
    encoding : "utf-8" or "ascii"
    """
    if not own:
        refuse_foreign(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(path, own=own) as temporary:
        errors = "replace" if encoding == "ascii" else "strict"
        temporary.write_text(text, encoding=encoding, errors=errors)


def kept_table(file: Path) -> dict[str, Any]:
    """Return the table of a JSON file that we have left; an empty one without a table there."""
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return table if isinstance(table, dict) else {}


def _clean(folder: Path) -> None:
    """Do `remove_unfinished` once for each folder."""
    if folder not in _cleaned:
        _cleaned.add(folder)
        remove_unfinished(folder)


def remove_unfinished(folder: Path) -> None:
    """Remove temporary files that processes of this machine have left which are no more."""
    with contextlib.suppress(OSError):
        for file in folder.iterdir():
            match = _OURS.fullmatch(file.name)
            if match and has_ended(int(match[1])):
                file.unlink(missing_ok=True)
