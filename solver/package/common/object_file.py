"""Write and read a file that holds one object: identity, data, checksum, and checks in between."""

import contextlib
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import h5py

from ...errors import PackageError
from .container import new_file, open_file
from .identity import (
    FileFormat,
    checksum_findings,
    identity_notes,
    unit_findings,
    write_checksum,
    write_identity,
)
from .read_before import keep, key_of, recall
from .remark import Remark, raise_first
from .vtk_view import view_findings

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
    view: tuple[str, str],
    doubts: Callable[[Object], list[Remark]] | None = None,
    on_doubt: Callable[[Object, list[Remark]], None] | None = None,
) -> Object:
    """Read the object of a file and check that its numbers can be used.

    A newer minor version of the format gives a warning only.

    Parameters
    ----------
    layout_findings : checks presence, type and shape of the datasets
    load : reads a file with a checked layout
    content_findings : checks the numbers
    view : group of the mesh and name of its nodes, which ParaView shows
    doubts : finds numbers that contradict each other, "error", or are suspicious
    on_doubt : called with what is contradictory; None: that is an error, too

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
        raise_first(path, checksum_findings(file, known) + unit_findings(file))
        raise_first(path, view_findings(file, *view))
        found = load(file)
    raise_first(path, content_findings(found))
    doubtful = [f for f in doubts(found) if f.level == "error"] if doubts is not None else []
    if on_doubt is None:
        raise_first(path, doubtful)
    elif doubtful:
        on_doubt(found, doubtful)
    if not notes and not doubtful:  # they are shown at each reading
        keep(key, known.group, found)
    return found
