"""Datasets of a result file: rows over time, records of named numbers and texts, bodies, joints."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import Any

import h5py
import numpy as np

from ..math.arrays import Array, IntArray
from ..math.rows import LongRows
from ..package.common.container import (
    as_text,
    is_text,
    new_dataset,
    set_numbers,
    set_text,
    text_array,
)
from ..package.common.dataset import build, field_values, layout
from ..package.common.plain_data import plain
from .run_result import BodyGeometry, BodyView, Link, Loads, ResultError, Side, Sites, Surface

# Datasets of a result file: rows over time, contiguous and not compressed (docs/adr/0044).

LARGE = 1_000_000  # size in bytes above which an array is written block by block
BLOCK = 2_000_000  # bytes that are written together
MAPPED = 16_000_000  # size in bytes above which an array is read as a mapping of the file


def blocks(shape: tuple[int, ...]) -> Iterator[tuple[int, int]]:
    """Yield first and end of blocks of rows."""
    rows = max(1, BLOCK // (8 * max(int(np.prod(shape[1:])), 1)))
    for first in range(0, shape[0], rows):
        yield first, min(first + rows, shape[0])


def read_array(dataset: h5py.Dataset) -> np.ndarray:
    """Return the content of a dataset: a large one as a mapping of the file.

    Its pages are read when they are used, so results need no memory of their size. What a user
    writes into the array stays in memory. Compressed datasets, of other writers, are read block by
    block: a signal counts between two of them.
    """
    if dataset.nbytes <= LARGE or not dataset.ndim:
        return np.asarray(dataset[()])
    offset = dataset.id.get_offset()
    if dataset.nbytes > MAPPED and offset is not None:
        return np.asarray(
            np.memmap(dataset.file.filename, dataset.dtype, "c", offset, dataset.shape)
        )
    values = np.empty(dataset.shape, dataset.dtype)
    for first, end in blocks(dataset.shape):
        values[first:end] = dataset[first:end]
    return values


class Datasets:
    """Arrays with unit, frame and meaning.

    Parameters
    ----------
    total : bytes that will be written, about
    progress : called with the part of them that is written
    """

    def __init__(self, total: int = 1, progress: Callable[[float], None] | None = None) -> None:
        self._total, self._progress, self._done = total, progress, 0

    def _report(self, size: int) -> None:
        self._done += size
        if self._progress is not None:
            self._progress(min(self._done / self._total, 1.0))

    def put(
        self,
        group: h5py.Group,
        name: str,
        values: Array | IntArray | LongRows,
        unit: str,
        frame: str,
        text: str,
    ) -> h5py.Dataset:
        """Write an array; a large one block by block.

        Parameters
        ----------
        group : group of the file
        name : name of the dataset
        values : its values
        unit : unit, "-" without one
        frame : frame of the components, "-" without one
        text : description
        """
        if values.nbytes > LARGE:
            dataset = group.create_dataset(name, values.shape, values.dtype)
            for first, end in blocks(values.shape):
                dataset[first:end] = values[first:end]
                self._report(values.nbytes * (end - first) // values.shape[0])
        else:
            dataset = new_dataset(group, name, np.asarray(values))
            self._report(values.nbytes)
        for key, word in (("unit", unit), ("frame", frame), ("description", text)):
            set_text(dataset, key, word)
        return dataset


# Records of named numbers and texts in a result file: a group for each, or one table of all.
#
# HDF5 takes about 5 ms for the group of a body or joint and 1 ms for the dataset of a signal. Where
# there are many, a table has a dataset for each field, with the values of all records end to end.

MOST_NAMED = 100  # signals that have a dataset of their own, joints whose loads are in pictures
MOST_GROUPS = 4  # bodies or joints that have a group of their own; a table of more is faster
ABSENT = -1  # number of axes of a value that a record does not have

Layout = Mapping[str, tuple[str, ...]]  # unit, frame and description of fields
Record = Mapping[str, Any]  # field, or group/field -> array, number or text


def write_record(group: h5py.Group, record: Record, layout: Layout) -> None:
    """Write a record into its group: fields of the layout as datasets, others as attributes.

    Parameters
    ----------
    group : group of the record
    record : values by name
    layout : unit, frame and description of datasets by name
    """
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
            set_numbers(item, key, value)


def read_record(group: h5py.Group) -> dict[str, object]:
    """Return what `write_record` wrote."""
    record: dict[str, object] = {}

    def take(path: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            record[path] = np.asarray(item[()])
        else:
            record.update(_attributes(f"{path}/", item))

    group.visititems(take)
    return record | _attributes("", group)


def _attributes(path: str, item: h5py.HLObject) -> dict[str, object]:
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
    """Write records as a table: texts in rows; values end to end, with the shape of each.

    Parameters
    ----------
    group : group of the table
    names : name of each row
    records : values of each row by field
    layout : unit, frame and description of fields by name
    """
    write_texts(group, "name", names)
    for field in dict.fromkeys(chain.from_iterable(records)):
        values = [record.get(field) for record in records]
        known = [value for value in values if value is not None]
        if isinstance(known[0], str):
            write_texts(group, field, [value or "" for value in values])
            continue
        arrays = [None if value is None else np.asarray(value) for value in values]
        flat = np.concatenate([array for array in arrays if array is not None], axis=None)
        sizes = [() if array is None else (array.ndim, *array.shape) for array in arrays]
        width = max(map(len, sizes))
        rows = {size: (*size, *[ABSENT] * (width - len(size))) for size in set(sizes)}
        shapes = np.array([rows[size] for size in sizes], dtype=np.int64)
        put_array(group, f"{field}/values", flat, layout.get(field, ("-", "-")))
        put_array(group, f"{field}/shapes", shapes, ("-", "-"))


def read_table(group: h5py.Group) -> tuple[list[str], list[dict[str, object]]]:
    """Return names and records of a table. Raises KeyError, ValueError for a damaged one."""
    names = read_texts(group["name"])
    records: list[dict[str, object]] = [{} for _ in names]
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
    parts: list[Any] = []
    at = 0
    for axes, *shape in shapes.tolist():
        if axes == ABSENT:
            parts.append(None)
            continue
        size = int(np.prod(shape[:axes], dtype=np.int64))
        parts.append(flat[at : at + size].reshape(shape[:axes]))
        at += size
    if at != len(flat):
        raise ValueError(f"{len(flat)} values, expected {at}")
    return parts


def write_texts(group: h5py.Group, name: str, texts: Sequence[str]) -> None:
    """Write texts (n,) as fixed-length UTF-8.

    Parameters
    ----------
    group : group of the file
    name : name of the dataset
    texts : the texts (n,)
    """
    put_array(group, name, text_array(texts), ("-", "-"))


def read_texts(dataset: h5py.Dataset) -> list[str]:
    """Return the texts (n,) of a dataset. Raises ValueError if it has none."""
    if not is_text(dataset.dtype):
        raise ValueError(f"{dataset.name}: expected texts")
    return [as_text(text) for text in dataset[()]]


def put_array(group: h5py.Group, name: str, values: Any, texts: tuple[str, ...]) -> None:
    """Write an array with its unit, frame and description, as far as they are known.

    Parameters
    ----------
    group : group of the file
    name : name of the dataset
    values : its values
    texts : unit, frame and description
    """
    dataset = new_dataset(group, name, np.asarray(values))
    for key, word in zip(("unit", "frame", "description"), texts, strict=False):
        set_text(dataset, key, word)


SURFACE, SITES = "surface/", "sites/"  # groups of a body
SPECS = (*layout(BodyGeometry), *layout(BodyView), *layout(Surface, SURFACE), *layout(Loads))
# Unit and frame of each dataset of a body or of the loads, and a description if it has one.
LAYOUT = {s.path: tuple(filter(None, (s.unit, s.frame, s.text))) for s in SPECS}
SIDE = ("position_B", "A_BM", "phi_B", "psi_B")


def view_record(view: BodyView) -> Record:
    """Return what a file has of the view of a body."""
    record: dict[str, object] = {
        "first_position": view.first_position,
        "mass": view.mass,
        "labels": json.dumps(view.labels) if view.labels else "[]",
        "provenance": json.dumps(plain(view.provenance, finite=True)) if view.provenance else "{}",
    }
    record |= field_values(view) | field_values(view.surface, SURFACE)
    if view.sites is not None:
        record["sites/plies"] = json.dumps(plain(view.sites.plies, finite=True))
        record["sites/dimension"] = view.sites.dimension
    return record


def link_record(link: Link) -> Record:
    """Return what a file has of a joint: m, rad; axes as in results/run_result.py."""
    record: dict[str, object] = {"kind": link.kind, "free": json.dumps(link.free)}
    for number, side in enumerate(link.sides, 1):
        record[f"body_{number}"] = side.body
        record |= {f"{name}_{number}": getattr(side, name) for name in SIDE}
    return record


def body_of(where: str, name: str, record: Record) -> BodyGeometry:
    """Return a body from its record. Raises ResultError.

    Parameters
    ----------
    where : place in the file, for messages
    name : name of the body
    record : values by name
    """
    with _damaged(where):
        return build(BodyGeometry, record, name=name, view=_view(record))


def _view(record: Record) -> BodyView | None:
    """Return the view of a body; None if its record has none."""
    if "shapes_B" not in record:
        return None
    sites = None
    if "sites/kind" in record:
        plies = tuple(json.loads(record["sites/plies"]))
        shell = np.shape(record["sites/resultants_E"])[1] == 8  # of a file without the dimension
        dimension = int(record.get("sites/dimension", 2 if shell else 1))
        sites = build(Sites, record, SITES, plies=plies, dimension=dimension)
    surface = build(Surface, record, SURFACE)
    return build(
        BodyView,
        record,
        first_position=int(record["first_position"]),
        labels=tuple(json.loads(record["labels"])),
        mass=float(record["mass"]),
        draw=lambda: surface,
        sites=sites,
        provenance=json.loads(record["provenance"]),
    )


def link_of(where: str, name: str, record: Record) -> Link:
    """Return a joint from its record. Raises ResultError.

    Parameters
    ----------
    where : place in the file, for messages
    name : name of the joint
    record : values by name
    """
    with _damaged(where):
        one, two = (
            Side(
                int(record[f"body_{number}"]),
                *(np.asarray(record[f"{name}_{number}"]) for name in SIDE),
            )
            for number in (1, 2)
        )
        free = tuple(json.loads(record.get("free") or "[]"))
        return Link(name, str(record["kind"]), (one, two), free)


def loads_of(where: str, record: Record) -> Loads:
    """Return the loads from their record. Raises ResultError."""
    with _damaged(where):
        loads: Loads = build(Loads, record, names=tuple(json.loads(record["names"])))
        r, n = len(loads.t), len(loads.names)
        if loads.place_G.shape != (r, n, 3) or loads.load_G.shape != (r, n, 6):
            raise ValueError(f"expected places and loads of {r} times and {n} names")
    return loads


@contextmanager
def _damaged(where: str) -> Iterator[None]:
    """Missing and damaged entries as ResultError with file and group."""
    try:
        yield
    except (KeyError, TypeError, ValueError) as error:
        raise ResultError(f"{where}: damaged view: {error}") from error
