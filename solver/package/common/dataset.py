"""Fields of dataclasses as datasets of HDF5: one mapper for all file formats.

A field names shape, unit, frame and meaning once; writer, reader, checks and manual follow from it:

    nodes_B: Annotated[Array, Data("n, 3", "m", "B", "rest positions of the nodes", "mesh/nodes_B")]

The type of a dataset is that of the field: an array of floats or integers, a number, a text, texts,
or a table (stored as JSON text). Shapes are numbers and symbols. The first dataset with a symbol as
its first axis defines the size; groups of named members take the sizes of the body that owns them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cache
from types import NoneType
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from ...errors import PackageError, did_you_mean
from ...math.arrays import Array, IntArray
from ...math.records import record
from .container import as_text, get_text, is_text, new_dataset, set_text, text_array
from .findings import Remark
from .plain_data import json_table, json_text

Object = TypeVar("Object")
Sizes = Mapping[str, int]
Datasets = dict[str, Any]  # by path: arrays, numbers, texts and tables
Contents = Mapping[str, h5py.HLObject]  # of a group by path, with itself as ""

WORDS = ("unit", "frame", "description")  # attributes of datasets
WORTH_PACKING = 6000  # bytes; HDF5 adds an index of about 2300 to a compressed dataset


class Data(NamedTuple):
    """A dataset: of a field, or complete as one of a layout."""

    shape: str = ""  # as "m, n, 6"
    unit: str = "-"
    frame: str = "-"  # of the components
    text: str = ""  # its meaning
    path: str = ""  # below the group of the object; absent: the name of the field
    # float64, int64, uint8, text (fixed-length UTF-8), json (such text), attribute (such text of a
    # group); absent: that of the field
    type: str = ""
    optional: bool = False  # as a field that may be None
    packed: bool = False  # if it is large
    within: str = ""  # group without which it is not expected

    @property
    def axes(self) -> list[str]:
        """Numbers and symbols of the shape."""
        return self.shape.split(", ") if self.shape else []

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

    @property
    def words(self) -> str:
        """The shape in words: (m, n, 6), or scalar."""
        return f"({self.shape})" if self.shape else "scalar"


class Attribute(NamedTuple):
    """A text attribute of the group."""

    default: str = ""


class Nested(NamedTuple):
    """A dataclass of its own, in a group or without one; `via` has the form in which it is stored.

    `via` is a dataclass with the classmethod `of`, which takes the value, and `value`, the inverse.
    """

    path: str = ""
    via: Any = None
    packed: bool = False  # large datasets are compressed


class Rows(NamedTuple):
    """Dataclasses of the same kind as a table: a dataset for each of their fields."""

    path: str
    size: str


class Named(NamedTuple):
    """Dataclasses of the same kind: a group for each, by its name; in order by `index`."""

    path: str
    packed: bool = False


class _Field(NamedTuple):
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
    fields = []
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if get_origin(hint) is Annotated:
            base, mark = get_args(hint)
            optional = NoneType in get_args(base)
            base = get_args(base)[0] if optional else base
            fields.append(_Field(name, base, mark, optional))
    return tuple(fields)


def _kind(item: Any) -> Any:
    return type(item)


def _below(at: str, path: str) -> str:
    return f"{at}{path}/" if path else at


@cache
def layout(kind: Any, at: str = "", packed: bool = False) -> tuple[Data, ...]:
    """Return datasets and attributes of a dataclass, without those of named members.

    Parameters
    ----------
    kind : the dataclass
    at : path of its group, with a slash at the end
    packed : whether its datasets are compressed
    """
    datasets: list[Data] = []
    for field in _fields(kind):
        mark = field.mark
        if isinstance(mark, Data):
            table = dict in (get_origin(field.base), *map(get_origin, get_args(field.base)))
            kind_ = mark.type or _TYPES.get(field.base, "json" if table else "text")
            path, optional = at + (mark.path or field.name), mark.optional or field.optional
            datasets.append(mark._replace(path=path, type=kind_, optional=optional, packed=packed))
        elif isinstance(mark, Attribute):
            datasets.append(Data(path=at + field.name, type="attribute", optional=True))
        elif isinstance(mark, Nested):
            specs = layout(mark.via or field.base, _below(at, mark.path), packed or mark.packed)
            group = specs[0].place if field.optional else ""
            datasets += [s._replace(within=s.within or group) for s in specs]
        elif isinstance(mark, Rows):
            rows = layout(field.item, _below(at, mark.path), packed)
            datasets += [s._replace(shape=", ".join((mark.size, *s.axes))) for s in rows]
    return tuple(datasets)


@cache
def named(kind: Any) -> dict[str, tuple[Any, bool]]:
    """Return the groups of named members of a dataclass: their kind, and whether it is packed."""
    marks = [(f, f.mark) for f in _fields(kind) if isinstance(f.mark, Named)]
    return {mark.path: (field.item, mark.packed) for field, mark in marks}


@cache
def _sized_by(kind: Any) -> dict[str, str]:
    """Return the path of the dataset that defines each symbol."""
    sizes: dict[str, str] = {}
    for spec in layout(kind):
        if spec.axes and spec.axes[0].isidentifier():
            sizes.setdefault(spec.axes[0], spec.path)
    return sizes


def field_values(item: Any, at: str = "") -> Datasets:
    """Return the values of a dataclass by path, without those of named members."""
    values: Datasets = {}
    for field in _fields(_kind(item)):
        value, mark = getattr(item, field.name), field.mark
        if value is None:
            continue
        if isinstance(mark, Data):  # first: there are many
            if not mark.optional or len(value):
                values[at + (mark.path or field.name)] = value
        elif isinstance(mark, Nested):
            stored = value if mark.via is None else mark.via.of(value)
            values |= field_values(stored, _below(at, mark.path))
        elif isinstance(mark, Rows):
            columns = [(f.name, f.mark.path or f.name) for f in _fields(field.item)]
            for name, path in columns:
                column = [getattr(row, name) for row in value]
                values[f"{_below(at, mark.path)}{path}"] = column
        elif isinstance(mark, Attribute):
            values[at + field.name] = value
    return values


def members(item: Any) -> Iterator[tuple[str, int, Any]]:
    """Yield a dataclass, then its named members: group that holds them, index, and member."""
    yield "", 0, item
    for field in _fields(_kind(item)):
        if isinstance(field.mark, Named):
            rows = enumerate(getattr(item, field.name))
            yield from ((field.mark.path, index, member) for index, member in rows)


def all_values(item: Any) -> Datasets:
    """Return the values of a dataclass and of its named members by path."""
    values: Datasets = {}
    for parent, _, one in members(item):
        values |= field_values(one, f"{parent}/{one.name}/" if parent else "")
    return values


def build(
    kind: Callable[..., Object], data: Mapping[str, Any], at: str = "", **given: Any
) -> Object:
    """Return a dataclass from its values by path; `given` are fields from elsewhere.

    Parameters
    ----------
    kind : the dataclass
    data : values by path
    at : path of its group, with a slash at the end
    given : fields from elsewhere

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
        elif isinstance(mark, Nested):
            below, stored = _below(at, mark.path), mark.via or base
            there = not field.optional or layout(stored, below)[0].path in data
            value = build(stored, data, below) if there else None
            given[field.name] = value.value() if value is not None and mark.via else value
        elif isinstance(mark, Rows):
            columns = [(f.base, f.mark.path or f.name) for f in _fields(field.item)]
            of_fields = (map(b, data[f"{_below(at, mark.path)}{path}"]) for b, path in columns)
            given[field.name] = tuple(field.item(*row) for row in zip(*of_fields, strict=True))
    return kind(**given)


def rebuilt(item: Object, values: Mapping[str, Any]) -> Object:
    """Return a dataclass with other values of its datasets, by path as in `all_values`."""

    def one(old: Any, at: str) -> Any:
        known = {field.name for field in _fields(_kind(old))}
        given = {f.name: getattr(old, f.name) for f in fields(old) if f.name not in known}
        for field in _fields(_kind(old)):
            if isinstance(field.mark, Named):
                below = field.mark.path
                rows = getattr(old, field.name)
                given[field.name] = tuple(one(row, f"{below}/{row.name}/") for row in rows)
        return build(_kind(old), values, at, **given)

    result: Object = one(item, "")
    return result


def shapes_by_path(item: Any) -> dict[str, str]:
    """Return the shapes, as symbols, of all datasets of a dataclass and of its named members."""
    return {
        f"{parent}/{one.name}/{spec.path}" if parent else spec.path: spec.shape
        for parent, _, one in members(item)
        for spec in layout(_kind(one))
    }


def _of_kind(base: Any, value: Any) -> Any:
    if base in (Array, IntArray):
        return np.asarray(value, dtype=_TYPES[base])
    return base(value) if base in (float, int, str) else value


def _expected_shape(spec: Data, sizes: Sizes) -> tuple[int, ...]:
    sizes = {**sizes, "c+1": sizes["c"] + 1} if "c" in sizes else sizes
    return tuple(int(axis) if axis.isdigit() else sizes[axis] for axis in spec.axes)


def _encoded(where: str, spec: Data, value: Any, sizes: Sizes) -> Any:
    """Return the array of a dataset. Raises PackageError for a wrong type or shape."""
    if spec.type == "attribute":
        return str(value)
    if spec.stored == "text":
        texts = list(value) if spec.shape else [value]
        texts = [json_text(where, one) if spec.type == "json" else one for one in texts]
        array: Any = text_array(texts).reshape(() if not spec.shape else -1)
    else:
        array, dtype = np.asarray(value), np.dtype(spec.type)
        kinds = "iu" if dtype.kind in "iu" else "fiu"
        if array.dtype.kind not in kinds and array.size:
            raise PackageError(f"{where}: expected {spec.type}, got {array.dtype}")
        array = array.astype(dtype, copy=False)
    expected = _expected_shape(spec, sizes)
    if array.shape != expected:
        raise PackageError(f"{where}: expected shape {spec.words} = {expected}, got {array.shape}")
    return array


Encoded = tuple[str, int, list[tuple[Data, Any]]]  # group, index among members, datasets


def encoded(where: str, item: Any) -> list[Encoded]:
    """Return all datasets of an object as arrays, group by group.

    `where` names file and group for PackageError: a wrong type or shape, a name that HDF5 does not
    take or that occurs twice, a table that JSON cannot hold.
    """
    by_path: dict[str, Encoded] = {}
    sizes: dict[str, int] = {}  # of the object, then of one member
    for parent, index, one in members(item):
        at = f"{parent}/{one.name}/" if parent else ""
        if parent:
            check_name(f"{where}/{parent}", one.name, at in by_path)
        own = field_values(one)
        known = sizes | {s: len(own[p]) for s, p in _sized_by(_kind(one)).items() if p in own}
        sizes = sizes or known
        packed = named(_kind(item))[parent][1] if parent else False
        specs = [spec for spec in layout(_kind(one), "", packed) if spec.path in own]
        arrays = [(s, _encoded(f"{where}/{at}{s.path}", s, own[s.path], known)) for s in specs]
        by_path[at] = at, index, arrays
    return list(by_path.values())


def check_name(where: str, name: str, twice: bool) -> None:
    """Raise PackageError for a name that no group can have, or that occurs twice.

    Parameters
    ----------
    where : file and group, for messages
    name : of a member
    twice : whether another one has it
    """
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
            if array.nbytes > WORTH_PACKING and (spec.packed or _is_mostly_zero(array)):
                # VTK's views of the modes read one after the other
                chunks = (1, *array.shape[1:]) if spec.axes[0] == "m" else array.shape
                options: Any = {"chunks": chunks, "compression": "gzip", "shuffle": True}
                dataset = own.create_dataset(spec.path, data=array, **options)
            else:
                dataset = new_dataset(own, spec.path, array)
            for key, word in zip(WORDS, (spec.unit, spec.frame, spec.text), strict=True):
                set_text(dataset, key, word)


def _is_mostly_zero(array: Array) -> bool:
    """A third of it at least, as rotations of solids and rotary inertia of their nodes."""
    return array.dtype.kind == "f" and 3 * int(np.count_nonzero(array)) <= 2 * array.size


def _read_dataset(dataset: h5py.Dataset, spec: Data) -> Any:
    if spec.stored != "text":
        return np.asarray(dataset[()], dtype=spec.type)[()]
    texts: Any = [as_text(text) for text in (dataset[()] if spec.shape else [dataset[()]])]
    if spec.type == "json":
        where = f"{dataset.file.filename}: {dataset.name}"
        texts = [json_table(where, text) for text in texts]
    return tuple(texts) if spec.shape else texts[0]


def read_fields(items: Contents, kind: Callable[..., Object], at: str = "", **given: Any) -> Object:
    """Return the object of a group with a checked layout; `given` are fields from elsewhere.

    Parameters
    ----------
    items : all below the group of the object, as `contents` returns it
    kind : the dataclass
    at : path of its group, with a slash at the end
    given : fields from elsewhere
    """
    for field in _fields(kind):
        if isinstance(field.mark, Named):
            below = f"{at}{field.mark.path}"
            names = sorted(
                items.get(below, ()),
                key=lambda name: int(items[f"{below}/{name}"].attrs.get("index", 0)),
            )
            given[field.name] = tuple(
                read_fields(items, field.item, f"{below}/{name}/", name=name) for name in names
            )
    values: Datasets = {}
    for spec in layout(kind):
        if spec.type == "attribute":
            if text := get_text(items[f"{at}{spec.place}".rstrip("/")], spec.name):
                values[spec.path] = text
        elif at + spec.path in items:
            values[spec.path] = _read_dataset(items[at + spec.path], spec)
    return build(kind, values, **given)


def layout_findings(
    items: Contents, kind: type, at: str = "", owner: Sizes | None = None
) -> list[Remark]:
    """Compare the datasets of a group with the format: presence, type, shape.

    Parameters
    ----------
    items : all below the group of the object, as `contents` returns it
    kind : the dataclass
    at : path of its group, with a slash at the end
    owner : sizes by symbol of the body that owns the group
    """
    sizes, where, findings = dict(owner or {}), f"{items[''].name}/{at}", list[Remark]()
    for symbol, path in _sized_by(kind).items():
        item = items.get(at + path)
        if isinstance(item, h5py.Dataset) and item.ndim > 0:
            sizes[symbol] = item.shape[0]
    for spec in layout(kind):
        item = items.get(at + spec.path)
        if spec.type == "attribute" or (spec.within and at + spec.within not in items):
            continue
        if isinstance(item, h5py.Dataset):
            text = _fault(spec, item, sizes)
        elif item is None and spec.optional:
            continue
        else:
            known = [path.removeprefix(at) for path in items if path.startswith(at)]
            hint = did_you_mean(spec.path, known)
            text = f"missing; expected {spec.stored} {spec.words}{hint}"
        if text:
            findings.append(Remark("error", where + spec.path, text))
    for parent, (member, _) in named(kind).items():
        for name in items.get(at + parent, ()):
            below = f"{at}{parent}/{name}"
            if isinstance(items.get(below), h5py.Group):
                findings += layout_findings(items, member, f"{below}/", sizes)
            else:
                findings.append(Remark("error", f"{where}{parent}/{name}", "expected a group"))
    return findings


def _fault(spec: Data, item: h5py.Dataset, sizes: Sizes) -> str:
    """Return what is wrong with type or shape of a dataset; axes of unknown sizes pass."""
    dtype, shape = item.dtype, item.shape
    if is_text(dtype) != (spec.stored == "text"):
        return f"expected {spec.stored}, found {dtype}"
    if spec.type in ("int64", "uint8") and dtype.kind not in "iu":
        return f"expected whole numbers ({spec.type}), found {dtype}"
    if spec.type == "float64" and dtype.kind not in "fiu":
        return f"expected float64, found {dtype}"
    if spec.shape and not item.ndim:
        return f"expected shape {spec.words}, found a single value"
    known = {*sizes, *(("c+1",) if "c" in sizes else ())}
    if {axis for axis in spec.axes if not axis.isdigit()} <= known:
        expected = _expected_shape(spec, sizes)
        if shape != expected:
            return f"expected shape {spec.words} = {expected}, found {shape}"
    return ""


@record
class Reported:
    """Warnings {"code", "message"} as they are stored."""

    codes: Annotated[tuple[str, ...], Data("w", text="a word for each warning of the analysis")]
    messages: Annotated[tuple[str, ...], Data("w", text="the warning for people")]

    @classmethod
    def of(cls, warnings: Sequence[Mapping[str, str]]) -> "Reported":
        """Return the columns of warnings."""
        return cls(*(tuple(w[key] for w in warnings) for key in ("code", "message")))

    def value(self) -> tuple[dict[str, str], ...]:
        """Return the warnings."""
        rows = zip(self.codes, self.messages, strict=True)
        return tuple({"code": code, "message": message} for code, message in rows)
