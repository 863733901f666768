"""HDF5 files: atomic writing, text attributes, clear error messages.

Works with h5py 3.7 (HDF5 1.10) and later. Text is fixed-length UTF-8, because
variable-length text needs a 4 kB heap per file object and prevents reproducible bytes.

A file is read alone: hard links and virtual datasets of the file itself are followed, links to
other files are refused.
"""

import contextlib
import hashlib
import json
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...errors import PackageError
from ...system.interrupts import uninterrupted
from .files import DiskFile, has_right_seal, sealed_bytes, temporary_sibling

SMALL = 200_000_000  # bytes that any file may have
PACKED = 1100  # bytes of data in a byte of a file: more than gzip can pack


def refuse_foreign_parts(path: Path, file: h5py.File, error: type[Exception]) -> None:
    """Raise `error` for the first link, storage or source outside the file, or soft link.

    Also for more data than a file of its size can hold: arrays that nobody has written, or packed
    twice, would fill the memory with a single value.

    Parameters
    ----------
    path : path of the file, for messages
    file : open HDF5 file
    error : class of the error
    """
    seen: set[int] = set()
    room = max(SMALL, PACKED * path.stat().st_size)

    def visit(group: h5py.h5g.GroupID, at: str) -> None:
        nonlocal room
        for name in group:
            where = f"{path}: {at}/{_text(name)}"
            kind = group.links.get_info(name).type
            if kind != h5py.h5l.TYPE_HARD:
                raise error(f"{where}: {INSIDE}, found {LINKS.get(kind, 'a link of another kind')}")
            item = h5py.h5o.open(group, name)
            address = h5py.h5o.get_info(item).addr
            if address in seen:
                continue
            seen.add(address)
            if isinstance(item, h5py.h5d.DatasetID):
                size = item.get_space().get_simple_extent_npoints() * item.get_type().get_size()
                _dataset(where, item, error)
                room -= size
                if room < 0:
                    raise error(f"{where}: {size} bytes, more than this file can hold")
            elif isinstance(item, h5py.h5g.GroupID):
                visit(item, f"{at}/{_text(name)}")

    root = file["/"].id  # HDF5's own functions: h5py's objects take five times as long
    seen.add(h5py.h5o.get_info(root).addr)
    visit(root, "")


INSIDE = "expected data in the file itself"
LINKS = {h5py.h5l.TYPE_EXTERNAL: "a link to another file", h5py.h5l.TYPE_SOFT: "a soft link"}


def _dataset(where: str, dataset: h5py.h5d.DatasetID, error: type[Exception]) -> None:
    stored = dataset.get_create_plist()
    if stored.get_external_count():
        raise error(f"{where}: {INSIDE}, found storage in another file")
    if stored.get_layout() == h5py.h5d.VIRTUAL:
        for source in h5py.Dataset(dataset).virtual_sources():
            if source.file_name != ".":
                text = f"found a virtual dataset of the file {source.file_name!r}"
                raise error(f"{where}: {INSIDE}, {text}")


def _text(name: str | bytes) -> str:
    return name if isinstance(name, str) else name.decode("utf-8", "backslashreplace")


SIGNATURE = b"\x89HDF\r\n\x1a\n"
LIBVER = ("earliest", "v110")  # readable by HDF5 1.10 and by VTK
MOST_DEEP = 20  # groups in groups: a link to an outer group would never end
MAX_ATTRIBUTE = 60_000  # HDF5 stores larger attributes in a form that old libraries cannot read


@contextlib.contextmanager
def new_file(path: Path) -> Iterator[h5py.File]:
    """Open a new HDF5 file under a temporary name; it is renamed to `path` when complete.

    Raises OSError : no room on the disk, with the size of the file.
    """
    with temporary_sibling(path) as temporary, DiskFile(temporary) as disk:
        with written_through(disk) as file:
            yield file
        disk.seal()


@contextlib.contextmanager
def written_through(disk: DiskFile) -> Iterator[h5py.File]:
    """Open a new HDF5 file that is closed before `disk` is, also after a signal."""
    with disk.reported():
        file = _opened(disk)
        try:
            yield file
        finally:
            _close(file)


@uninterrupted
def _opened(disk: DiskFile) -> h5py.File:
    return h5py.File(disk, "w", libver=LIBVER)


@uninterrupted
def _close(file: h5py.File) -> None:
    file.close()


@contextlib.contextmanager
def open_file(path: Path, error: type[Exception]) -> Iterator[h5py.File]:
    """Open an HDF5 file for reading; raise `error` if this fails."""
    if not path.is_file():
        raise error(f"{path}: no such file")
    with path.open("rb") as raw:
        head = raw.read(16)
        if not sealed_bytes(raw):
            raise error(f"{path}: damaged: its bytes were altered after writing")
    if not head.startswith(SIGNATURE):
        raise error(f"{path}: not an HDF5 file but {_kind_of_bytes(head)}")
    try:
        with h5py.File(path, "r") as file:
            refuse_foreign_parts(path, file, error)
            yield file
    except (OSError, LookupError, RuntimeError, ValueError, TypeError, MemoryError) as cause:
        if "truncated" in str(cause):
            message = f"truncated: {path.stat().st_size} bytes found, more are expected"
        else:
            message = "damaged HDF5 file, or data of another shape"
        raise error(f"{path}: {message} ({cause})") from cause


def has_fingerprint(file: Path, expected: str) -> bool:
    """Return whether a file has this fingerprint, and all bytes as they were written."""
    try:
        with open_file(file, PackageError) as content:
            recorded = json.loads(get_text(content, "provenance", "{}")).get("fingerprint")
    except (PackageError, ValueError, AttributeError):
        return False
    return bool(recorded == expected) and has_right_seal(file)


def _kind_of_bytes(head: bytes) -> str:
    known = {
        b"": "an empty file",
        b"PK\x03\x04": "a zip archive (.npz?)",
        b"\x93NUMPY": "a NumPy .npy file",
        b"<?xml": "an XML file (.vtu?)",
        b"CDF": "a classic NetCDF file",
        b"# vtk": "a legacy VTK file",
        b"$MeshFormat": "a gmsh mesh",
        b"{": "a JSON file; of a body in build/CASE/bodies the package is NAME.vtkhdf beside it",
    }
    for start, name in known.items():
        if head == start or (start and head.startswith(start)):
            return name
    return "a text file" if head.isascii() and b"\0" not in head else "something else"


def kind_of_file(file: h5py.File) -> str:
    """Identify an HDF5 file of another program, for an error message."""
    names = set(file)
    if {"ENS_MAA", "INFOS_GENERALES"} & names:
        return "a MED file (Salome, Code_Aster)"
    if "_NCProperties" in file.attrs:
        return "a NetCDF-4 file"
    if "#refs#" in names:
        return "a MATLAB 7.3 file"
    if "VTKHDF" in names:
        return "a VTKHDF file without modal data"
    if "Mesh" in names:
        return "the HDF5 part of an XDMF file"
    shown = ", ".join(sorted(names)[:5]) or "nothing"
    return f"an HDF5 file with {shown}"


# HDF5's own functions are used where files have many objects: those of h5py's objects take twice
# as long, and writing and checking packages is a fifteenth of the CPU time of our tests.
ONE = h5py.h5s.create(h5py.h5s.SCALAR)
UNDATED = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
UNDATED.set_obj_track_times(False)  # the same content gives the same bytes
WITH_GROUPS = h5py.h5p.create(h5py.h5p.LINK_CREATE)
WITH_GROUPS.set_create_intermediate_group(True)


@cache
def _kind_of_text(size: int) -> tuple[h5py.h5t.TypeID, np.dtype[Any]]:
    dtype = h5py.string_dtype("utf-8", size)
    return h5py.h5t.py_create(dtype, logical=True), dtype


def set_text(item: h5py.HLObject, name: str, text: str) -> None:
    """Store text as an attribute of fixed length. Raises ValueError if it is too long.

    Parameters
    ----------
    item : group, dataset or file
    name : name of the attribute
    text : its text
    """
    raw = text.encode("utf-8")
    if len(raw) > MAX_ATTRIBUTE:
        raise ValueError(f"attribute {name} has {len(raw)} bytes, the limit is {MAX_ATTRIBUTE}")
    kind, dtype = _kind_of_text(max(len(raw), 1))
    _set(item, name, kind, np.array(raw, dtype))


def set_numbers(item: h5py.HLObject, name: str, values: Any) -> None:
    """Store a number or an array as an attribute.

    Parameters
    ----------
    item : group, dataset or file
    name : name of the attribute
    values : its value
    """
    array = np.asarray(values)
    _set(item, name, h5py.h5t.py_create(array.dtype, logical=True), array)


def _set(item: h5py.HLObject, name: str, kind: h5py.h5t.TypeID, value: np.ndarray) -> None:
    place = name.encode("utf-8")
    if h5py.h5a.exists(item.id, place):
        h5py.h5a.delete(item.id, place)
    space = h5py.h5s.create_simple(value.shape) if value.shape else ONE
    h5py.h5a.create(item.id, place, kind, space).write(value, mtype=kind)


def as_text(value: Any) -> str:
    """Convert any HDF5 text value (fixed or variable length) to str."""
    if isinstance(value, np.ndarray) and value.shape in ((), (1,)):
        value = value.reshape(())[()]
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)


def get_text(item: h5py.HLObject, name: str, default: str = "") -> str:
    """Return a text attribute, or a text dataset of that name.

    Parameters
    ----------
    item : group, dataset or file
    name : name of the attribute or dataset
    default : text if there is none
    """
    if name in item.attrs:
        return as_text(item.attrs[name])
    if isinstance(item, h5py.Group) and isinstance(item.get(name), h5py.Dataset):
        return as_text(item[name][()])
    return default


def set_long_text(group: h5py.Group, name: str, text: str) -> None:
    """Store text as an attribute, or as a dataset of that name if it is too long.

    Parameters
    ----------
    group : group of the file
    name : name of the attribute or dataset
    text : its text
    """
    if len(text.encode("utf-8")) <= MAX_ATTRIBUTE:
        set_text(group, name, text)
    else:
        raw = text.encode("utf-8")
        group.create_dataset(name, data=np.bytes_(raw), dtype=h5py.string_dtype("utf-8", len(raw)))


def new_dataset(group: h5py.Group, path: str, array: np.ndarray) -> h5py.Dataset:
    """Store an array as a dataset in one piece; groups of its path are created.

    Parameters
    ----------
    group : group of the file
    path : name of the dataset, with groups in front of it
    array : values
    """
    kind = h5py.h5t.py_create(array.dtype, logical=True)
    extent = h5py.h5s.create_simple(array.shape)
    made = h5py.h5d.create(group.id, path.encode("utf-8"), kind, extent, UNDATED, WITH_GROUPS)
    made.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(array))
    return h5py.Dataset(made)


def text_array(texts: Sequence[str]) -> np.ndarray:
    """Return texts (n,) as fixed-length UTF-8."""
    raw = [text.encode("utf-8") for text in texts]
    return np.array(raw, dtype=h5py.string_dtype("utf-8", max([1, *map(len, raw)])))


def is_text(dtype: np.dtype[Any]) -> bool:
    """True for the type of a dataset that contains text."""
    return h5py.check_string_dtype(dtype) is not None


def content_sha256(group: h5py.Group, *preamble: str) -> str:
    """Hash names, attributes and values of a group in a canonical order.

    Data with two names are hashed with each.

    The rule (docs/format.md repeats it for other writers): a sequence of items,
    each its length in bytes as decimal text, a colon, and the bytes. Items are
    the preamble; then for the group and everything below it, sorted by path,
    the path; for each attribute, sorted by name, its name and value; for a
    dataset its value. A value is text, or its shape ("3,4"), "f8" or "i8", and
    the numbers as little-endian 64-bit in C order.

    Parameters
    ----------
    group : group, with all below it
    preamble : texts before the group
    """
    digest = hashlib.sha256()

    def item(raw: bytes) -> None:
        digest.update(b"%d:" % len(raw))
        digest.update(raw)

    def value(data: np.ndarray) -> None:
        if data.dtype.kind in "SOU":
            texts = (t if isinstance(t, bytes) else str(t).encode() for t in data.ravel().tolist())
            digest.update(b"".join(b"%d:%b" % (len(raw), raw) for raw in texts))
            return
        kind = "f8" if data.dtype.kind == "f" else "i8"
        item(",".join(map(str, data.shape)).encode())
        item(kind.encode())
        digest.update(b"%d:" % (8 * data.size))
        digest.update(np.ascontiguousarray(data, dtype=f"<{kind}").ravel().data)

    for text in preamble:
        item(text.encode("utf-8"))
    members = contents(group)
    for path in sorted(members, key=_name_bytes):
        item(_name_bytes(path))
        member = members.pop(path)  # HDF5 keeps what was read of a dataset until it is closed
        names: list[bytes] = []
        h5py.h5a.iterate(member.id, names.append)
        for name in sorted(names):
            item(name)
            value(_attribute(member, name))
        if isinstance(member, h5py.Dataset):
            value(_values(member.id, member.shape))
    return digest.hexdigest()


def _values(dataset: h5py.h5d.DatasetID, shape: tuple[int, ...]) -> np.ndarray:
    if dataset.dtype.kind == "O" or 0 in shape:
        return np.asarray(h5py.Dataset(dataset)[()])
    data = np.empty(shape, dataset.dtype)
    dataset.read(h5py.h5s.ALL, h5py.h5s.ALL, data)
    return data


def _attribute(item: h5py.HLObject, name: bytes) -> np.ndarray:
    attribute = h5py.h5a.open(item.id, name)
    kind, shape = attribute.get_type(), attribute.shape
    plain = isinstance(kind, h5py.h5t.TypeIntegerID | h5py.h5t.TypeFloatID)
    if isinstance(kind, h5py.h5t.TypeStringID) and not kind.is_variable_str():
        plain = kind.get_strpad() == h5py.h5t.STR_NULLPAD
    if shape is None or not plain:
        return np.asarray(item.attrs[name])
    data = np.empty(shape, kind.dtype)
    attribute.read(data, mtype=kind)
    return data


def contents(group: h5py.Group) -> dict[str, h5py.HLObject]:
    """Return a group and all below it by path, each opened once, as opening takes most time.

    Parameters
    ----------
    group : group of the file

    Raises
    ------
    ValueError : groups nested deeper than MOST_DEEP
    """
    found: dict[str, h5py.HLObject] = {"": group}
    readonly = group.file.mode == "r"

    def add(parent: h5py.h5g.GroupID, at: str, depth: int) -> None:
        if depth > MOST_DEEP:
            raise ValueError(f"groups nested deeper than {MOST_DEEP}")
        for name in parent:
            item = h5py.h5o.open(parent, name)
            path = at + name.decode("utf-8", "surrogateescape")
            if isinstance(item, h5py.h5g.GroupID):
                found[path] = h5py.Group(item)
                add(item, f"{path}/", depth + 1)
            elif isinstance(item, h5py.h5d.DatasetID):
                found[path] = h5py.Dataset(item, readonly=readonly)
            else:
                found[path] = h5py.Datatype(item)

    add(group.id, "", 0)
    return found


def _name_bytes(name: str | bytes) -> bytes:
    """Names that are not UTF-8 (a damaged file) come from h5py as bytes."""
    return name if isinstance(name, bytes) else name.encode("utf-8", "surrogateescape")
