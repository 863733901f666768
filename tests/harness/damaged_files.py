"""Damage to HDF5 files, and what their readers then say."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import pytest
from samples.package_samples import same

from plymotion.solver.errors import PackageError
from plymotion.solver.package import validate

Change = Callable[[h5py.File], None]
Read = Callable[[Path], object]


def dropped(path: str) -> Change:
    """Take an object out of the file."""

    def change(file: h5py.File) -> None:
        del file[path]

    return change


def replaced(path: str, data: Any) -> Change:
    """Put other data in the place of an object."""

    def change(file: h5py.File) -> None:
        del file[path]
        file[path] = data

    return change


def alter(file: Path, *changes: Change, seal: bool = True) -> None:
    """Change a file; `seal=False` takes the checksum out, so that the reader looks at the rest."""
    with h5py.File(file, "r+") as h5:
        for change in changes:
            change(h5)
        if not seal:
            del h5.attrs["content_sha256"]


def refused(read: Read, file: Path) -> str:
    """Return the message with which a reader refuses a file; it names the file."""
    with pytest.raises(PackageError) as caught:
        read(file)
    assert str(file) in str(caught.value)
    return str(caught.value)


def cut_is_refused(raw: bytes, part: float, file: Path, read: Read) -> None:
    """Write the first part (0 to 1) of the bytes of a file: reader and `validate` refuse it."""
    file.write_bytes(raw[: int(part * len(raw))])
    refused(read, file)
    assert [finding.level for finding in validate(file)] == ["error"]


def wrong_byte_is_refused_or_harmless(
    raw: bytes, place: float, byte: int, file: Path, read: Read, sample: object
) -> None:
    """Harmless: in the gaps between objects, in provenance, or in the ParaView part."""
    damaged = bytearray(raw)
    damaged[int(place * len(raw))] ^= byte
    file.write_bytes(damaged)
    try:
        found = vars(read(file))
    except PackageError as error:
        message = str(error)
    else:
        numbers = {name: value for name, value in found.items() if name != "provenance"}
        assert all(same(getattr(sample, name), value) for name, value in numbers.items())
        return
    assert f"{file.name}: " in message
