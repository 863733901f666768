"""Fields of dataclasses as datasets of HDF5: one mapper for all file formats.

A field names shape, unit, frame and meaning once; writer, reader, checks and manual follow from it:

    nodes_B: Annotated[Array, Data("n, 3", "m", "B", "rest positions of the nodes", "mesh/nodes_B")]

The type of a dataset is that of the field: an array of floats or integers, a number, a text, texts,
or a table (stored as JSON text). Shapes are numbers and symbols. The first dataset with a symbol as
its first axis defines the size; groups of named members take the sizes of the body that owns them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import NoneType
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from ...errors import PackageError, did_you_mean
from ...math.arrays import Array, IntArray
from .container import as_text, get_text, is_text, set_text
from .identity import json_table, json_text
from .remark import Remark

Object = TypeVar("Object")
Sizes = Mapping[str, int]

WORTH_PACKING = 8192  # bytes; HDF5 adds an index to a compressed dataset


@dataclass(frozen=True)
class Data:
    """A dataset; its path is the name of the field unless it is given."""

    shape: str = ""  # as "m, n, 6"
    unit: str = "-"
    frame: str = "-"  # of the components
    text: str = ""
    path: str = ""
    type: str = ""  # if another one than that of the field
    optional: bool = False  # as a field that may be None


@dataclass(frozen=True)
class Attribute:
    """A text attribute of the group."""

    default: str = ""


@dataclass(frozen=True)
class Part:
    """A dataclass of its own, in a group or without one; `via` has the form in which it is stored.

    `via` is a dataclass with the classmethod `of`, which takes the value, and `value`, the inverse.
    """

    path: str = ""
    via: Any = None
    packed: bool = False  # large datasets are compressed


@dataclass(frozen=True)
class Rows:
    """Dataclasses of the same kind as a table: a dataset for each of their fields."""

    path: str
    size: str


@dataclass(frozen=True)
class Named:
    """Dataclasses of the same kind: a group for each, by its name; in order by `index`."""

    path: str
    packed: bool = False


@dataclass(frozen=True)
class DatasetSpec:
    """One dataset of a file: path, shape, type, unit, frame and meaning."""

    path: str  # below the group of the format
    shape: tuple[str | int, ...]
    type: str  # float64, int64, uint8, text (fixed-length UTF-8), json (such text), or attribute
    unit: str
    frame: str  # of the components, or "-"
    description: str
    optional: bool = False
    packed: bool = False
    within: str = ""  # group without which it is not expected

    @property
    def place(self) -> str:
        """Group of the dataset or attribute, below that of the object."""
        return self.path.rpartition("/")[0]

    @property
    def name(self) -> str:
        """Last part of the path."""
        return self.path.rpartition("/")[2]

    @property
    def stored(self) -> str:
        """Type of the dataset."""
        return "text" if self.type == "json" else self.type


@dataclass(frozen=True)
class _Field:
    name: str
    base: Any  # type of the value, if it is not None
    mark: Any
    optional: bool

    @property
    def item(self) -> Any:
        """Type of the members of a tuple."""
        return get_args(self.base)[0]


_TYPES = {Array: "float64", float: "float64", IntArray: "int64", int: "int64"}


@cache
def _fields(kind: Any) -> tuple[_Field, ...]:
    found = []
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if get_origin(hint) is Annotated:
            base, mark = get_args(hint)
            optional = NoneType in get_args(base)
            base = get_args(base)[0] if optional else base
            found.append(_Field(name, base, mark, optional))
    return tuple(found)


def _kind(item: Any) -> Any:
    return type(item)


def _below(at: str, path: str) -> str:
    return f"{at}{path}/" if path else at


@cache
def layout(kind: Any, at: str = "", packed: bool = False) -> tuple[DatasetSpec, ...]:
    """Return datasets and attributes of a dataclass, without those of named members."""
    found: list[DatasetSpec] = []
    for field in _fields(kind):
        mark = field.mark
        if isinstance(mark, Data):
            axes = mark.shape.replace(",", " ").split()
            shape = tuple(int(axis) if axis.isdigit() else axis for axis in axes)
            table = dict in (get_origin(field.base), *map(get_origin, get_args(field.base)))
            type_ = mark.type or _TYPES.get(field.base, "json" if table else "text")
            words, optional = (mark.unit, mark.frame, mark.text), mark.optional or field.optional
            path = at + (mark.path or field.name)
            found.append(DatasetSpec(path, shape, type_, *words, optional, packed))
        elif isinstance(mark, Attribute):
            found.append(DatasetSpec(at + field.name, (), "attribute", "", "", "", True))
        elif isinstance(mark, Part):
            specs = layout(mark.via or field.base, _below(at, mark.path), packed or mark.packed)
            group = specs[0].place if field.optional else ""
            found += [replace(s, within=s.within or group) for s in specs]
        elif isinstance(mark, Rows):
            rows = layout(field.item, _below(at, mark.path), packed)
            found += [replace(s, shape=(mark.size, *s.shape)) for s in rows]
    return tuple(found)


@cache
def named(kind: Any) -> dict[str, tuple[Any, bool]]:
    """Return the groups of named members of a dataclass: their kind, and whether it is packed."""
    marks = [(f, f.mark) for f in _fields(kind) if isinstance(f.mark, Named)]
    return {mark.path: (field.item, mark.packed) for field, mark in marks}


@cache
def _sized_by(kind: Any) -> dict[str, str]:
    """Return the path of the dataset that defines each symbol."""
    found: dict[str, str] = {}
    for spec in layout(kind):
        if spec.shape and isinstance(spec.shape[0], str):
            found.setdefault(spec.shape[0], spec.path)
    return found


def field_values(item: Any, at: str = "") -> dict[str, Any]:
    """Return the values of a dataclass by path, without those of named members."""
    found: dict[str, Any] = {}
    for field in _fields(_kind(item)):
        value, mark = getattr(item, field.name), field.mark
        if value is None:
            continue
        if isinstance(mark, Part):
            stored = value if mark.via is None else mark.via.of(value)
            found |= field_values(stored, _below(at, mark.path))
        elif isinstance(mark, Rows):
            columns = [(f.name, f.mark.path or f.name) for f in _fields(field.item)]
            for name, path in columns:
                column = [getattr(row, name) for row in value]
                found[f"{_below(at, mark.path)}{path}"] = column
        elif isinstance(mark, Attribute):
            found[at + field.name] = value
        elif isinstance(mark, Data) and not (mark.optional and not len(value)):
            found[at + (mark.path or field.name)] = value
    return found


def members(item: Any) -> Iterator[tuple[str, int, Any]]:
    """Yield a dataclass, then its named members: group that holds them, index, and member."""
    yield "", 0, item
    for field in _fields(_kind(item)):
        if isinstance(field.mark, Named):
            rows = enumerate(getattr(item, field.name))
            yield from ((field.mark.path, index, member) for index, member in rows)


def all_values(item: Any) -> dict[str, Any]:
    """Return the values of a dataclass and of its named members by path."""
    found: dict[str, Any] = {}
    for parent, _, one in members(item):
        found |= field_values(one, f"{parent}/{one.name}/" if parent else "")
    return found


def mapped(item: Object, change: Callable[[str, Any], Any]) -> Object:
    """Return a dataclass with `change(shape, array)` of each array, parts and members included."""
    new: dict[str, Any] = {}
    for field in _fields(_kind(item)):
        value, mark = getattr(item, field.name), field.mark
        if isinstance(mark, Data) and isinstance(value, np.ndarray):
            new[field.name] = change(mark.shape, value)
        elif isinstance(mark, Part) and mark.via is None and value is not None:
            new[field.name] = mapped(value, change)
        elif isinstance(mark, Named):
            new[field.name] = tuple(mapped(member, change) for member in value)
    changed: Any = item
    return replace(changed, **new)


def build(
    kind: Callable[..., Object], data: Mapping[str, Any], at: str = "", **given: Any
) -> Object:
    """Return a dataclass from its values by path; `given` are fields from elsewhere.

    Raises KeyError for a missing value.
    """
    for field in _fields(kind):
        mark, base = field.mark, field.base
        if field.name in given:
            continue
        if isinstance(mark, Data):
            path = at + (mark.path or field.name)
            if path in data or not (field.optional or mark.optional):
                given[field.name] = _of_kind(base, data[path])
            elif field.optional:
                given[field.name] = None
        elif isinstance(mark, Attribute):
            given[field.name] = str(data.get(at + field.name, mark.default))
        elif isinstance(mark, Part):
            below, stored = _below(at, mark.path), mark.via or base
            there = not field.optional or layout(stored, below)[0].path in data
            found = build(stored, data, below) if there else None
            given[field.name] = found.value() if found is not None and mark.via else found
        elif isinstance(mark, Rows):
            columns = [(f.base, f.mark.path or f.name) for f in _fields(field.item)]
            of_fields = (map(b, data[f"{_below(at, mark.path)}{path}"]) for b, path in columns)
            given[field.name] = tuple(field.item(*row) for row in zip(*of_fields, strict=True))
    return kind(**given)


def _of_kind(base: Any, value: Any) -> Any:
    if base in (Array, IntArray):
        return np.asarray(value, dtype=_TYPES[base])
    return base(value) if base in (float, int, str) else value


def shape_text(shape: tuple[str | int, ...]) -> str:
    """Return a symbolic shape as text: (m, n, 6), or scalar."""
    return f"({', '.join(map(str, shape))})" if shape else "scalar"


def _expected_shape(spec: DatasetSpec, sizes: Sizes) -> tuple[int, ...]:
    sizes = {**sizes, "c+1": sizes["c"] + 1} if "c" in sizes else sizes
    return tuple(axis if isinstance(axis, int) else sizes[axis] for axis in spec.shape)


def _encoded(where: str, spec: DatasetSpec, value: Any, sizes: Sizes) -> Any:
    """Return the array of a dataset. Raises PackageError for a wrong type or shape."""
    if spec.type == "attribute":
        return str(value)
    if spec.stored == "text":
        texts = list(value) if spec.shape else [value]
        json = spec.type == "json"
        raw = [(json_text(where, one) if json else one).encode("utf-8") for one in texts]
        width = max([1, *map(len, raw)])
        array: Any = np.array(
            raw if spec.shape else raw[0], dtype=h5py.string_dtype("utf-8", width)
        )
    else:
        array, dtype = np.asarray(value), np.dtype(spec.type)
        kinds = "iu" if dtype.kind in "iu" else "fiu"
        if array.dtype.kind not in kinds and array.size:
            raise PackageError(f"{where}: expected {spec.type}, got {array.dtype}")
        array = array.astype(dtype, copy=False)
    expected = _expected_shape(spec, sizes)
    if array.shape != expected:
        symbols = shape_text(spec.shape)
        raise PackageError(f"{where}: expected shape {symbols} = {expected}, got {array.shape}")
    return array


Encoded = tuple[str, int, list[tuple[DatasetSpec, Any]]]  # group, index among members, datasets


def encoded(where: str, item: Any) -> list[Encoded]:
    """Return all datasets of an object as arrays, group by group.

    `where` names file and group for PackageError: a wrong type or shape, a name that HDF5 does not
    take or that occurs twice, a table that JSON cannot hold.
    """
    found: dict[str, Encoded] = {}
    sizes: dict[str, int] = {}  # of the object, then of one member
    for parent, index, one in members(item):
        at = f"{parent}/{one.name}/" if parent else ""
        if parent:
            _check_name(f"{where}/{parent}", one.name, at in found)
        own = field_values(one)
        known = sizes | {s: len(own[p]) for s, p in _sized_by(_kind(one)).items() if p in own}
        sizes = sizes or known
        packed = named(_kind(item))[parent][1] if parent else False
        specs = [spec for spec in layout(_kind(one), "", packed) if spec.path in own]
        arrays = [(s, _encoded(f"{where}/{at}{s.path}", s, own[s.path], known)) for s in specs]
        found[at] = at, index, arrays
    return list(found.values())


def _check_name(where: str, name: str, twice: bool) -> None:
    if not name or name == "." or "/" in name or "\0" in name:
        raise PackageError(f"{where}: {name!r} is not a valid name (empty, '.', or with '/')")
    if twice:
        raise PackageError(f"{where}: the name {name!r} occurs twice")


def write_encoded(group: h5py.Group, datasets: Iterable[Encoded]) -> None:
    """Write datasets with unit, frame and meaning."""
    for at, index, arrays in datasets:
        own = group.create_group(at) if at else group
        if at:
            own.attrs["index"] = np.int64(index)
        for spec, array in arrays:
            if spec.type == "attribute":
                set_text(own.require_group(f"./{spec.place}"), spec.name, array)
                continue
            large = spec.packed and array.nbytes > WORTH_PACKING
            how = {"chunks": array.shape, "compression": "gzip", "shuffle": True} if large else {}
            dataset = own.create_dataset(spec.path, data=array, dtype=array.dtype, **how)
            for key in ("unit", "frame", "description"):
                set_text(dataset, key, getattr(spec, key))


def read_datasets(group: h5py.Group, specs: Iterable[DatasetSpec]) -> dict[str, Any]:
    """Return the values of the existing datasets and attributes of a layout, by path."""
    found: dict[str, Any] = {}
    for spec in specs:
        if spec.type == "attribute":
            if text := get_text(group[f"./{spec.place}"], spec.name):
                found[spec.path] = text
        elif spec.path in group:
            found[spec.path] = _read_dataset(group[spec.path], spec)
    return found


def _read_dataset(dataset: h5py.Dataset, spec: DatasetSpec) -> Any:
    if spec.stored != "text":
        return np.asarray(dataset[()], dtype=spec.type)[()]
    texts: Any = [as_text(text) for text in (dataset[()] if spec.shape else [dataset[()]])]
    if spec.type == "json":
        where = f"{dataset.file.filename}: {dataset.name}"
        texts = [json_table(where, text) for text in texts]
    return tuple(texts) if spec.shape else texts[0]


def read_fields(group: h5py.Group, kind: Callable[..., Object], **given: Any) -> Object:
    """Return the object of a group with a checked layout; `given` are fields from elsewhere."""
    for field in _fields(kind):
        if isinstance(field.mark, Named):
            items = list(group[field.mark.path].values()) if field.mark.path in group else []
            items.sort(key=lambda g: int(g.attrs.get("index", 0)))
            given[field.name] = tuple(
                read_fields(g, field.item, name=g.name.rsplit("/", 1)[1]) for g in items
            )
    return build(kind, read_datasets(group, layout(kind)), **given)


def layout_findings(group: h5py.Group, kind: type, owner: Sizes | None = None) -> list[Remark]:
    """Compare the datasets of a group with the format: presence, type, shape."""
    sizes = dict(owner or {})
    for symbol, path in _sized_by(kind).items():
        if isinstance(group.get(path), h5py.Dataset) and group[path].ndim > 0:
            sizes[symbol] = group[path].shape[0]
    wanted = (s for s in layout(kind) if s.type != "attribute")
    specs = [s for s in wanted if not s.within or s.within in group]
    findings = _missing_or_mistyped(group, specs) + _misshaped(group, specs, sizes)
    for parent, (member, _) in named(kind).items():
        for name in group.get(parent, ()):
            item = group[parent][name]
            if isinstance(item, h5py.Group):
                findings += layout_findings(item, member, sizes)
            else:
                findings.append(Remark("error", item.name, "expected a group"))
    return findings


def _missing_or_mistyped(group: h5py.Group, specs: Iterable[DatasetSpec]) -> list[Remark]:
    found: list[str] = []
    group.visit(found.append)
    findings = []
    for spec in specs:
        item = group.get(spec.path)
        if item is None and spec.optional:
            continue
        where = f"{group.name}/{spec.path}"
        if not isinstance(item, h5py.Dataset):
            hint = did_you_mean(spec.path, found)
            text = f"missing; expected {spec.stored} {shape_text(spec.shape)}{hint}"
            findings.append(Remark("error", where, text))
        elif is_text(item) != (spec.stored == "text"):
            findings.append(Remark("error", where, f"expected {spec.stored}, found {item.dtype}"))
        elif spec.type in ("int64", "uint8") and item.dtype.kind not in "iu":
            text = f"expected whole numbers ({spec.type}), found {item.dtype}"
            findings.append(Remark("error", where, text))
        elif spec.type == "float64" and item.dtype.kind not in "fiu":
            findings.append(Remark("error", where, f"expected float64, found {item.dtype}"))
        elif spec.shape and not item.ndim:
            text = f"expected shape {shape_text(spec.shape)}, found a single value"
            findings.append(Remark("error", where, text))
    return findings


def _misshaped(group: h5py.Group, specs: Iterable[DatasetSpec], sizes: Sizes) -> list[Remark]:
    """Find shapes that differ from the sizes; unknown symbols are not checked, nor scalars."""
    known = {*sizes, *(("c+1",) if "c" in sizes else ())}
    findings = []
    for spec in specs:
        item = group.get(spec.path)
        symbols = {axis for axis in spec.shape if isinstance(axis, str)}
        if not isinstance(item, h5py.Dataset) or (spec.shape and not item.ndim):
            continue
        if symbols <= known and item.shape != (expected := _expected_shape(spec, sizes)):
            text = f"expected shape {shape_text(spec.shape)} = {expected}, found {item.shape}"
            findings.append(Remark("error", f"{group.name}/{spec.path}", text))
    return findings
