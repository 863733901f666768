"""Records of named numbers and texts in a result file: a group for each, or one table of all.

HDF5 takes about 5 ms for the group of a body or joint and 1 ms for the dataset of a signal. Where
there are many, a table has a dataset for each field, with the values of all records end to end.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import h5py
import numpy as np

from ..package.common.container import as_text, is_text, set_text

MOST_NAMED = 100  # bodies, joints or signals that have a group or dataset of their own
ABSENT = -1  # number of axes of a value that a record does not have
PACKED = 50_000  # bytes above which an array is compressed

Layout = Mapping[str, tuple[str, ...]]  # unit, frame and description of fields
Record = Mapping[str, Any]  # field, or group/field -> array, number or text


def write_record(group: h5py.Group, record: Record, layout: Layout) -> None:
    """Write a record into its group: fields of the layout as datasets, others as attributes."""
    for name, value in record.items():
        if name in layout:
            put_array(group, name, value, layout[name])
    for name, value in record.items():
        if name in layout:
            continue
        place, _, key = name.rpartition("/")
        item = group[place] if place else group
        if isinstance(value, str):
            set_text(item, key, value)
        else:
            item.attrs[key] = value


def read_record(group: h5py.Group) -> dict[str, Any]:
    """Return what `write_record` wrote."""
    found: dict[str, Any] = {}

    def take(path: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            found[path] = np.asarray(item[()])
        else:
            found.update(_attributes(f"{path}/", item))

    group.visititems(take)
    return found | _attributes("", group)


def _attributes(path: str, item: h5py.HLObject) -> dict[str, Any]:
    return {
        f"{path}{key}": as_text(value) if isinstance(value, bytes | str) else value
        for key, value in item.attrs.items()
    }


def write_table(
    group: h5py.Group,
    names: Sequence[str],
    records: Sequence[Record],
    layout: Layout,
) -> None:
    """Write records as a table: texts in rows; values end to end, with the shape of each."""
    write_texts(group, "name", names)
    for field in dict.fromkeys(key for record in records for key in record):
        values = [record.get(field) for record in records]
        if any(isinstance(value, str) for value in values):
            write_texts(group, field, [value or "" for value in values])
            continue
        arrays = [None if value is None else np.asarray(value) for value in values]
        known = [array for array in arrays if array is not None]
        flat = np.concatenate([array.ravel() for array in known])
        shapes = np.full((len(arrays), 1 + max(a.ndim for a in known)), ABSENT, dtype=np.int64)
        for row, array in zip(shapes, arrays, strict=True):
            if array is not None:
                row[: 1 + array.ndim] = array.ndim, *array.shape
        put_array(group, f"{field}/values", flat, layout.get(field, ("-", "-")))
        put_array(group, f"{field}/shapes", shapes, ("-", "-"))


def read_table(group: h5py.Group) -> tuple[list[str], list[dict[str, Any]]]:
    """Return names and records of a table. Raises KeyError, ValueError for a damaged one."""
    names = read_texts(group["name"])
    records: list[dict[str, Any]] = [{} for _ in names]
    for field, item in _fields(group):
        if isinstance(item, h5py.Dataset):
            values: list[Any] = list(read_texts(item))
        else:
            values = _split(item["values"][()], item["shapes"][()])
        for record, value in zip(records, values, strict=True):
            if value is not None:
                record[field] = value
    return names, records


def _fields(group: h5py.Group, path: str = "") -> Iterator[tuple[str, h5py.HLObject]]:
    for key, item in group.items():
        if isinstance(item, h5py.Group) and "shapes" not in item:
            yield from _fields(item, f"{path}{key}/")
        elif path or key != "name":
            yield f"{path}{key}", item


def _split(flat: Any, shapes: Any) -> list[Any]:
    found: list[Any] = []
    at = 0
    for axes, *shape in shapes.tolist():
        if axes == ABSENT:
            found.append(None)
            continue
        size = int(np.prod(shape[:axes], dtype=np.int64))
        found.append(flat[at : at + size].reshape(shape[:axes]))
        at += size
    if at != len(flat):
        raise ValueError(f"{len(flat)} values, expected {at}")
    return found


def write_texts(group: h5py.Group, name: str, texts: Sequence[str]) -> None:
    """Write texts (n,) as fixed-length UTF-8."""
    raw = [text.encode("utf-8") for text in texts]
    width = max([1, *map(len, raw)])
    put_array(group, name, np.array(raw, dtype=h5py.string_dtype("utf-8", width)), ("-", "-"))


def read_texts(dataset: h5py.Dataset) -> list[str]:
    """Return the texts (n,) of a dataset. Raises ValueError if it has none."""
    if not is_text(dataset):
        raise ValueError(f"{dataset.name}: expected texts")
    return [as_text(text) for text in dataset[()]]


def put_array(group: h5py.Group, name: str, values: Any, words: tuple[str, ...]) -> None:
    """Write an array with its unit, frame and description, as far as there are words."""
    array = np.asarray(values)
    squeeze = {"compression": "gzip", "shuffle": True} if array.nbytes > PACKED else {}
    dataset = group.create_dataset(name, data=array, **squeeze)
    for key, word in zip(("unit", "frame", "description"), words, strict=False):
        set_text(dataset, key, word)
