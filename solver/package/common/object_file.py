"""Write and read a file that holds one object: identity, data, checksum, and checks in between.

Objects that were read and found good are kept in the user's cache. Reading and checking a package
takes 0.05 s, most of it in calls of h5py, and 0.2 s if it has 30 modes with second-order fields;
its object comes back in 1 to 10 ms. The key is the digest of every byte of the file and of the
sources of this folder, so that nothing is left unchecked: other bytes, or other checks, are other
keys. An entry is a line of JSON and the bytes of its arrays: reading one runs no code, as a pickle
would.
"""

import dataclasses
import hashlib
import importlib
import json
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

import h5py
import numpy as np

from ...errors import PackageError
from ...math.disk_cache import DiskCache, sources_sha256
from ...math.records import record
from .container import (
    content_sha256,
    contents,
    get_text,
    kind_of_file,
    new_file,
    open_file,
    set_long_text,
    set_text,
)
from .dataset import (
    Contents,
    all_values,
    encoded,
    layout_findings,
    read_fields,
    rebuilt,
    write_encoded,
)
from .design import GROUP, design_findings, read_design, write_design
from .files import has_seal
from .findings import Remark, finite, raise_first
from .plain_data import json_table, json_text
from .vtk_view import view_findings

UNITS = "SI"


@record
class FileFormat:
    """One file format: its name, version, and the group of its data."""

    format: str
    version: tuple[int, int]
    group: str  # group of all data, which the checksum covers
    title: str  # attribute of the root that names the object


def write_identity(file: h5py.File, known: FileFormat, name: str) -> None:
    """Write format, version, the object's name and units as attributes of the root.

    Parameters
    ----------
    file : open HDF5 file
    known : format of the file
    name : name of the object
    """
    set_text(file, "format", known.format)
    file.attrs["format_version"] = np.array(known.version, dtype=np.int64)
    set_text(file, known.title, name)
    set_text(file, "units", UNITS)


def write_checksum(file: h5py.File, known: FileFormat) -> None:
    """Write the checksum, after all data."""
    set_text(file, "content_sha256", _checksum(file, known))


def _checksum(file: h5py.File, known: FileFormat) -> str:
    return content_sha256(file[known.group], get_text(file, known.title), get_text(file, "units"))


def unit_findings(file: h5py.File) -> list[Remark]:
    """Check that the numbers of a file are in SI units."""
    units = get_text(file, "units", UNITS)
    if units == UNITS:
        return []
    return [Remark("error", "/", f"attribute units: expected {UNITS!r}, found {units!r}")]


def identity_notes(path: Path, file: h5py.File, known: FileFormat) -> list[Remark]:
    """Check that the format and version of a file are known. Raises PackageError.

    Parameters
    ----------
    path : path of the file, for messages
    file : open HDF5 file
    known : format that is expected
    """
    major, minor = version_of(path, file, known.format, [known.version[0]], PackageError)
    if not isinstance(file.get(known.group), h5py.Group):
        raise PackageError(f"{path}: /{known.group}: missing group")
    if minor <= known.version[1]:
        return []
    newest = ".".join(map(str, known.version))
    text = f"{path}: format {major}.{minor} is newer than {newest}: parts of it are not read"
    return [Remark("warning", "format_version", text)]


def version_of(
    path: Path, file: h5py.File, form: str, majors: list[int], error: type[Exception]
) -> tuple[int, int]:
    """Return major and minor version of a file. Raises `error` unless its format is a known one.

    Parameters
    ----------
    path : path of the file, for messages
    file : open HDF5 file
    form : name of the format
    majors : known major versions of it
    error : class of the error
    """
    if (found := get_text(file, "format")) != form:
        what = repr(found) if found else kind_of_file(file)
        raise error(f"{path}: attribute format: expected {form!r}, this is {what}")
    try:
        major, minor = (int(v) for v in np.ravel(file.attrs["format_version"]))
    except (KeyError, ValueError, TypeError, OverflowError):
        raise error(f"{path}: attribute format_version: expected [major, minor]") from None
    if major not in majors:
        age = "a newer" if major > max(majors) else "an older"
        raise error(
            f"{path}: written by {age} Plymotion: format {major}.{minor}, "
            f"this reader knows {' and '.join(f'{each}.x' for each in majors)}"
        )
    return major, minor


def checksum_findings(file: h5py.File, known: FileFormat, *, whole: bool = False) -> list[Remark]:
    """Compare the content with the stored checksum.

    Without `whole`, not that of a file with a seal: `open_file` has compared all its bytes.

    Parameters
    ----------
    file : open HDF5 file
    known : format of the file
    whole : hash the content of a file with a seal, too
    """
    stored = get_text(file, "content_sha256")
    if not stored:
        return [Remark("warning", "content_sha256", "no checksum: damage cannot be detected")]
    if not whole and has_seal(Path(file.filename)):
        return []
    actual = _checksum(file, known)
    if actual == stored:
        return []
    text = f"content was altered after writing: expected {stored[:12]}..., found {actual[:12]}..."
    return [Remark("error", "content_sha256", text)]


# Entries of a provenance that are shown, and their types: other programs write these files, too.
SHOWN: dict[str, tuple[type, ...]] = {
    "dofs": (int,),
    "seconds": (int, float),
    "refinements": (list,),
    "verification": (str, type(None)),
}
STEP = ("dofs", "error", "seconds")  # numbers of each of `refinements`


def check_provenance(file: Path, provenance: Mapping[str, Any]) -> None:
    """Raise PackageError if an entry that is shown is of another type."""
    for key, types in SHOWN.items():
        if key in provenance and not isinstance(provenance[key], types):
            names = " or ".join("none" if t is type(None) else t.__name__ for t in types)
            raise PackageError(
                f"{file}: provenance.{key}: expected {names}, found {provenance[key]!r:.40}"
            )
    steps = provenance.get("refinements", [])
    for row, step in enumerate(steps if len(steps) > 1 else []):  # one is not shown
        for key in STEP:
            if not isinstance(step, dict) or not isinstance(step.get(key), int | float):
                raise PackageError(
                    f"{file}: provenance.refinements[{row}].{key}: expected a number"
                )


MOST_FILES, MOST_BYTES = 200, 800_000_000
LARGEST = 32_000_000  # bytes of a file
PACKED = ".packed"  # ending of what a process writes for another one
_PACKAGE = __name__.removesuffix("common.object_file")  # whose dataclasses the objects are
_OBJECTS = DiskCache("packages", MOST_FILES, MOST_BYTES)


def _reader() -> bytes:
    """Return what the reading depends on, apart from the file."""
    return f"{sys.version} {np.__version__} {sources_sha256('solver/package')}".encode()


def key_of(path: Path) -> str | None:
    """Return the key of a file; None if it is none, cannot be read, or is too large to be kept."""
    try:
        if not path.is_file() or path.stat().st_size > LARGEST:
            return None
        return hashlib.sha256(_reader() + path.read_bytes()).hexdigest()
    except OSError:
        return None


def recall(key: str | None, kind: str) -> Any:
    """Return the object of a file of this kind; None if it was not kept."""
    content = _OBJECTS.read(f"{key}-{kind}") if key is not None else None
    return None if content is None else unpacked(content)


def keep(key: str | None, kind: str, item: Any) -> None:
    """Keep the object of a file that has no findings.

    Parameters
    ----------
    key : digest of the file; None: it is not kept
    kind : name of its format
    item : the object
    """
    if key is None:
        return
    try:
        content = b"".join(packed(item))
    except TypeError:  # it has a part of another kind
        return
    if len(content) <= LARGEST:
        _OBJECTS.write(f"{key}-{kind}", content)


def packed(item: Any) -> list[bytes | memoryview]:
    """Return an object as bytes, part by part. Raises TypeError for a part of another kind."""
    arrays: list[memoryview] = []
    head = json.dumps(_json_of(item, arrays)).encode()
    return [head, b"\n", *arrays]


def unpacked(content: bytes) -> Any:
    """Return the object that was `packed`."""
    end = content.index(b"\n")
    return _value_of(json.loads(content[:end]), memoryview(content)[end + 1 :])


def _json_of(value: Any, arrays: list[memoryview]) -> Any:
    """Return a value as JSON; what JSON does not have is a list of its kind and its parts."""
    if value is None or isinstance(value, str | int | float):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        order: Literal["C", "F"] = "C" if value.flags.c_contiguous else "F"
        flat = np.ascontiguousarray(value if order == "C" else value.T).reshape(-1)
        arrays.append(flat.view(np.uint8).data)
        return ["array", value.dtype.str, value.shape, order, value.nbytes]
    if isinstance(value, dict):
        return ["dict", [[_json_of(part, arrays) for part in pair] for pair in value.items()]]
    if isinstance(value, tuple | list):
        return [type(value).__name__, [_json_of(part, arrays) for part in value]]
    parts = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    kind = f"{type(value).__module__}:{type(value).__name__}"
    if not kind.startswith(_PACKAGE):
        raise TypeError(kind)
    return [kind, {name: _json_of(part, arrays) for name, part in parts.items()}]


def _value_of(value: Any, rest: memoryview) -> Any:
    """Return the value of its JSON and of the bytes of its arrays, in the order of both."""

    def read(value: Any) -> Any:
        nonlocal rest
        if not isinstance(value, list):
            return value
        kind, parts = value[0], value[1]
        if kind == "array":
            _, dtype, shape, order, size = value
            piece, rest = rest[:size], rest[size:]
            flat = np.frombuffer(piece, dtype=np.dtype(dtype)).copy()
            return flat.reshape(shape, order=order)
        if kind == "dict":
            return {read(name): read(part) for name, part in parts}
        if kind in ("tuple", "list"):
            values = [read(part) for part in parts]
            return tuple(values) if kind == "tuple" else values
        module, name = kind.removeprefix(_PACKAGE).split(":")
        known: Any = getattr(importlib.import_module(_PACKAGE + module), name)
        if not dataclasses.is_dataclass(known):
            raise TypeError(kind)
        made: Any = known
        return made(**{key: read(part) for key, part in parts.items()})

    return read(value)


Object = TypeVar("Object")
Loaded = TypeVar("Loaded")


@record
class ObjectFormat(FileFormat, Generic[Object]):
    """The format of an object that a dataclass describes (dataset.py)."""

    kind: type[Object]
    what: str  # kind of file, for messages
    nodes: str  # dataset of the nodes in the group `mesh`
    content: Callable[[Object], list[Remark]]  # checks the numbers
    view: Callable[[h5py.File, h5py.Group, Object], None]  # writes /VTKHDF
    # Finds numbers that contradict each other, "error", or are suspicious.
    doubts: Callable[[Object], Iterable[Remark]] = lambda _: ()

    def layout_findings(self, items: Contents, *, whole: bool = True) -> list[Remark]:
        """Compare the datasets of a file with the format: presence, type, shape.

        Without `whole`, not the derivatives of a file with a seal, which `write_design` compared.

        Parameters
        ----------
        items : `contents` of the group
        whole : compare all derivatives
        """
        findings, group = layout_findings(items, self.kind), items[""]
        if self._designed and (whole or not has_seal(Path(group.file.filename))):
            findings += design_findings(group)
        return findings

    @property
    def _designed(self) -> bool:
        return any(field.name == "design" for field in dataclasses.fields(self.kind))  # type: ignore[arg-type]

    def view_findings(self, file: h5py.File) -> list[Remark]:
        """Check that ParaView shows the mesh that this reader reads."""
        return view_findings(file, f"{self.group}/mesh", self.nodes)

    def load(self, items: Contents, kind: type[Loaded]) -> Loaded:
        """Read the object of a file with a checked layout, or a part of it, of this kind.

        Parameters
        ----------
        items : `contents` of the group
        kind : dataclass of the object or of a part
        """
        file = items[""].file
        provenance = get_text(file, "provenance", "{}")
        where = f"{file.filename}: attribute provenance"
        given: dict[str, Any] = {
            self.title: get_text(file, self.title),
            "provenance": json_table(where, provenance),
            **({"design": read_design(items[""])} if self._designed else {}),
        }
        return read_fields(items, kind, **given)


def write_object(path: str | Path, known: ObjectFormat[Object], item: Any) -> None:
    """Write an object under a temporary name, then rename it.

    Parameters
    ----------
    path : the file, with the ending .vtkhdf
    known : format of the file
    item : the object

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
        write_design(group, getattr(item, "design", ()), f"{path}: /{known.group}")
        known.view(file, group, item)
        write_checksum(file, known)


def write_packed(path: Path, known: ObjectFormat[Any], item: Any) -> None:
    """Write an object for another process of this program, which reads it once: see `unpacked`.

    Its numbers are checked as by `write_object`, which takes five times as long, and a later
    reading of the file as well.

    Parameters
    ----------
    path : the file
    known : format whose checks are made
    item : the object

    Raises
    ------
    PackageError
        The object is inconsistent.
    """
    encoded(f"{path}: /{known.group}", item)
    bad, made, design = known.content(item), rebuilt(item, all_values(item)), []
    for one in made.design:
        rates = {name: np.asarray(rate, np.float64) for name, rate in one.values.items()}
        design.append(dataclasses.replace(one, values=rates))
        for name, rate in rates.items():
            at = f"{GROUP}/{one.name}/{name}"
            finite(at, rate, lambda dataset, text: bad.append(Remark("error", dataset, text)))
    raise_first(path, bad)
    with path.open("wb") as file:
        file.writelines(packed(dataclasses.replace(made, design=tuple(design))))


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
        items = contents(file[known.group])
        raise_first(path, known.layout_findings(items, whole=False))
        raise_first(path, checksum_findings(file, known) + unit_findings(file))
        raise_first(path, known.view_findings(file))
        item = known.load(items, known.kind)
    raise_first(path, known.content(item))
    doubtful = [f for f in known.doubts(item) if f.level == "error"]
    if on_doubt is None:
        raise_first(path, doubtful)
    elif doubtful:
        on_doubt(item, doubtful)
    if not notes and not doubtful:  # they are shown at each reading
        keep(key, known.group, item)
    return item
