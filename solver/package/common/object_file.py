"""Write and read a file that holds one object: identity, data, checksum, and checks in between."""

import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import h5py

from ...errors import PackageError
from .container import get_text, new_file, open_file, set_long_text
from .dataset import encoded, layout_findings, read_fields, write_encoded
from .identity import (
    FileFormat,
    checksum_findings,
    identity_notes,
    json_table,
    json_text,
    unit_findings,
    write_checksum,
    write_identity,
)
from .read_before import keep, key_of, recall
from .remark import Remark, raise_first
from .vtk_view import view_findings

Object = TypeVar("Object")
Part = TypeVar("Part")


@dataclass(frozen=True)
class ObjectFormat(FileFormat, Generic[Object]):
    """The format of an object that a dataclass describes (dataset.py)."""

    kind: type[Object]
    what: str  # kind of file, for messages
    nodes: str  # dataset of the nodes in the group `mesh`
    content: Callable[[Object], list[Remark]]  # checks the numbers
    view: Callable[[h5py.File, h5py.Group, Object], None]  # writes /VTKHDF
    # Finds numbers that contradict each other, "error", or are suspicious.
    doubts: Callable[[Object], Iterable[Remark]] = lambda _: ()

    def layout_findings(self, file: h5py.File) -> list[Remark]:
        """Compare the datasets of a file with the format: presence, type, shape."""
        return layout_findings(file[self.group], self.kind)

    def view_findings(self, file: h5py.File) -> list[Remark]:
        """Check that ParaView shows the mesh that this reader reads."""
        return view_findings(file, f"{self.group}/mesh", self.nodes)

    def load(self, file: h5py.File, kind: type[Part]) -> Part:
        """Read the object of a file with a checked layout, or a part of it, of this kind."""
        provenance = get_text(file, "provenance", "{}")
        own = {
            self.title: get_text(file, self.title),
            "provenance": json_table(f"{file.filename}: attribute provenance", provenance),
        }
        return read_fields(file[self.group], kind, **own)


def write_object(path: str | Path, known: ObjectFormat[Object], item: Any) -> None:
    """Write an object under a temporary name, then rename it.

    Raises
    ------
    PackageError
        The path does not end in .vtkhdf, or the object is inconsistent (shapes, NaN, symmetry,
        rows, names). The message names file and dataset; nothing is written.
    """
    path = Path(path)
    if path.suffix != ".vtkhdf":
        text = f"expected {known.what} with the ending .vtkhdf, as ParaView needs it"
        raise PackageError(f"{path}: {text}")
    datasets = encoded(f"{path}: /{known.group}", item)
    raise_first(path, known.content(item))
    provenance = json_text(f"{path}: provenance", item.provenance)
    with new_file(path) as file:
        write_identity(file, known, getattr(item, known.title))
        group = file.create_group(known.group)
        set_long_text(file, "provenance", provenance)
        write_encoded(group, datasets)
        known.view(file, group, item)
        write_checksum(file, known)


def read_object(
    path: str | Path,
    known: ObjectFormat[Object],
    on_doubt: Callable[[Object, list[Remark]], None] | None = None,
) -> Object:
    """Read the object of a file and check that its numbers can be used.

    A newer minor version of the format gives a warning only.

    Parameters
    ----------
    on_doubt : called with contradictory numbers; None: they are an error, too

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
        raise_first(path, known.layout_findings(file))
        raise_first(path, checksum_findings(file, known) + unit_findings(file))
        raise_first(path, known.view_findings(file))
        found = known.load(file, known.kind)
    raise_first(path, known.content(found))
    doubtful = [f for f in known.doubts(found) if f.level == "error"]
    if on_doubt is None:
        raise_first(path, doubtful)
    elif doubtful:
        on_doubt(found, doubtful)
    if not notes and not doubtful:  # they are shown at each reading
        keep(key, known.group, found)
    return found
