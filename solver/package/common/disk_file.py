"""The bytes of an HDF5 file on a disk: errors of the disk, and a seal over all bytes.

HDF5 cannot be stopped in the middle of a file: an error of the disk while it writes may end the
whole program. It therefore writes through an object that notes the first error and accepts the
rest; the error is raised when HDF5 has closed the file.

The seal is a line after the end of the HDF5 file, which HDF5 ignores: reading a file with a wrong
byte may end the program as well. HDF5 removes it when it opens the file for changes.
"""

import contextlib
import errno
import hashlib
import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

SEAL = b"\nplymotion sha256 "
LENGTH = len(SEAL) + 64 + 1
BLOCK = 1 << 20
KEPT = 1 << 16  # size in bytes up to which blocks without room are kept, for HDF5 to read again


class DiskFile(io.RawIOBase):
    """A new file that HDF5 writes through; use it as a context."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = path.open("w+b", buffering=0)
        self._place = self._end = 0
        self._error: OSError | None = None
        self._kept: list[tuple[int, bytes]] = []

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the place of the next read or write."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._end}[whence]
        self._place = start + offset
        return self._place

    def tell(self) -> int:
        """Return the place of the next read or write."""
        return self._place

    def readable(self) -> bool:
        """HDF5 reads its own metadata again."""
        return True

    def writable(self) -> bool:
        """As it is."""
        return True

    def seekable(self) -> bool:
        """As it is."""
        return True

    def readinto(self, buffer: "bytearray | memoryview") -> int:  # type: ignore[override]
        """Read what was written, on the disk or not."""
        view = memoryview(buffer).cast("B")
        self._file.seek(self._place)
        found = self._file.read(len(view)) or b""
        view[: len(found)] = found
        view[len(found) :] = bytes(len(view) - len(found))
        for start, block in self._kept:
            first, last = max(start, self._place), min(start + len(block), self._place + len(view))
            if first < last:
                view[first - self._place : last - self._place] = block[first - start : last - start]
        self._place += len(view)
        return len(view)

    def write(self, data: "bytes | memoryview") -> int:  # type: ignore[override]
        """Write; an error of the disk is noted."""
        raw = memoryview(data).cast("B")
        done = 0
        try:
            if self._error is None:
                self._file.seek(self._place)
                while done < len(raw):
                    done += self._file.write(raw[done:]) or 0
        except OSError as error:
            self._error = error
        if self._error is not None and len(raw) - done <= KEPT:
            self._kept.append((self._place + done, bytes(raw[done:])))
        self._place += len(raw)
        self._end = max(self._end, self._place)
        return len(raw)

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        self._end = self._place if size is None else size
        if self._error is None:
            try:
                self._file.truncate(self._end)
            except OSError as error:
                self._error = error
        return self._end

    def flush(self) -> None:
        """Nothing is held back."""

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
        self._file.seek(0)
        while block := self._file.read(BLOCK):
            digest.update(block)
        self.seek(0, os.SEEK_END)
        self.write(SEAL + digest.hexdigest().encode() + b"\n")
        self._raise()

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

    def _raise(self) -> None:
        if self._error is None:
            return
        code = self._error.errno or errno.EIO
        words = f"{os.strerror(code)}; the file needs {self._end + LENGTH} bytes"
        with contextlib.suppress(OSError, AttributeError):
            room = os.statvfs(self.path.parent)
            words += f", {room.f_bavail * room.f_frsize} are free"
        raise OSError(code, words, str(self.path)) from self._error


def has_right_seal(path: Path) -> bool:
    """Tell whether a file is there, and whole to the last byte."""
    try:
        with path.open("rb") as file:
            return _ends_with_seal(file) and sealed_bytes(file)
    except OSError:
        return False


def has_seal(path: Path) -> bool:
    """Tell whether a file ends with a seal, right or wrong: `sealed_bytes` compares it."""
    with path.open("rb") as file:
        return _ends_with_seal(file)


def _ends_with_seal(file: BinaryIO) -> bool:
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - LENGTH, 0))
    return file.read(len(SEAL)) == SEAL


def sealed_bytes(file: BinaryIO) -> bool:
    """Tell whether all bytes of a file are as they were written; true for one without a seal."""
    size = file.seek(0, os.SEEK_END)
    if size < LENGTH:
        return True
    file.seek(size - LENGTH)
    found = file.read()
    if not found.startswith(SEAL):
        return not _is_cut(file, size)
    digest, left = hashlib.sha256(), size - LENGTH
    file.seek(0)
    while left:
        block = file.read(min(BLOCK, left))
        digest.update(block)
        left -= len(block)
    return found == SEAL + digest.hexdigest().encode() + b"\n"


def _is_cut(file: BinaryIO, size: int) -> bool:
    """Tell whether a file ends within its seal."""
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
