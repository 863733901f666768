"""Write and read a file that holds one object: identity, data, checksum, and checks in between."""

import contextlib
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import h5py

from ...errors import PackageError
from .container import new_file, open_file
from .identity import FileFormat, checksum_findings, identity_notes, write_checksum, write_identity
from .read_before import keep, key_of, recall
from .remark import Remark, raise_first

Object = TypeVar("Object")


@contextlib.contextmanager
def new_object_file(
    path: Path, known: FileFormat, name: str, what: str
) -> Iterator[tuple[h5py.File, h5py.Group]]:
    """Open a new file and its group for data; it appears under `path` only when it is complete.

    Parameters
    ----------
    name : of the object
    what : kind of file, for the message

    Raises
    ------
    PackageError : the path does not end in .vtkhdf.
    """
    if path.suffix != ".vtkhdf":
        raise PackageError(f"{path}: expected {what} with the ending .vtkhdf, as ParaView needs it")
    with new_file(path) as file:
        write_identity(file, known, name)
        yield file, file.create_group(known.group)
        write_checksum(file, known)


def read_object_file(
    path: str | Path,
    known: FileFormat,
    layout_findings: Callable[[h5py.Group], list[Remark]],
    load: Callable[[h5py.File], Object],
    content_findings: Callable[[Object], list[Remark]],
) -> Object:
    """Read the object of a file and check that its numbers can be used.

    A newer minor version of the format gives a warning only.

    Parameters
    ----------
    layout_findings : checks presence, type and shape of the datasets
    load : reads a file with a checked layout
    content_findings : checks the numbers

    Raises
    ------
    PackageError
        The file is missing, truncated, newer, incomplete, altered or of another format, or its
        numbers cannot be used; names file and dataset.
    """
    path = Path(path)
    key = key_of(path)
    before: Object | None = recall(key, known.group)
    if before is not None:
        return before
    with open_file(path, PackageError) as file:
        notes = identity_notes(path, file, known)
        for note in notes:
            warnings.warn(note.message, UserWarning, stacklevel=3)
        raise_first(path, layout_findings(file[known.group]))
        raise_first(path, checksum_findings(file, known))
        found = load(file)
    raise_first(path, content_findings(found))
    if not notes:  # they are shown at each reading
        keep(key, known.group, found)
    return found
