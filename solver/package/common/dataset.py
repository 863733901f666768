"""One dataset of a package: its row in the table of the format, and its storage in HDF5."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...errors import PackageError, did_you_mean
from .container import as_text, is_text, set_text
from .remark import Remark


@dataclass(frozen=True)
class DatasetSpec:
    """One dataset of the file: path, shape, type, unit, frame and meaning."""

    path: str  # below the group of the format
    shape: tuple[str | int, ...]
    type: str  # float64, int64, uint8 or text (fixed-length UTF-8)
    unit: str
    frame: str  # of the components, or "-"
    description: str
    optional: bool = False


WORTH_PACKING = (
    8192  # size in bytes above which data is compressed: HDF5 adds an index to a compressed dataset
)

F, I, T = "float64", "int64", "text"  # noqa: E741


def spec(
    path: str,
    shape: str,
    type: str,
    unit: str,
    frame: str,
    description: str,
    *,
    optional: bool = False,
) -> DatasetSpec:
    """Return a row of a layout table, its shape written as "m, n, 6"."""
    axes = tuple(int(s) if s.isdigit() else s for s in shape.replace(",", " ").split())
    return DatasetSpec(path, axes, type, unit, frame, description, optional)


def shape_text(shape: tuple[str | int, ...]) -> str:
    """Return a symbolic shape as text: (m, n, 6), or scalar."""
    return f"({', '.join(map(str, shape))})" if shape else "scalar"


def expected_shape(spec: DatasetSpec, sizes: Mapping[str, int]) -> tuple[int, ...]:
    """Replace the symbols of a shape by numbers."""
    sizes = {**sizes, "c+1": sizes["c"] + 1} if "c" in sizes else sizes
    return tuple(axis if isinstance(axis, int) else sizes[axis] for axis in spec.shape)


def encoded(where: str, spec: DatasetSpec, value: Any, sizes: Mapping[str, int]) -> Any:
    """Return the array of a dataset. Raises PackageError for a wrong type or shape."""
    if spec.type == "text":
        texts = [value] if isinstance(value, str) else list(value)
        raw = [text.encode("utf-8") for text in texts]
        width = max([1, *map(len, raw)])
        array: Any = np.array(
            raw if spec.shape else raw[0], dtype=h5py.string_dtype("utf-8", width)
        )
    else:
        array, dtype = np.asarray(value), np.dtype(spec.type)
        kinds = "iu" if dtype.kind in "iu" else "fiu"
        if array.dtype.kind not in kinds and array.size:
            raise PackageError(f"{where}: expected {spec.type}, got {array.dtype}")
        array = array.astype(dtype)
    expected = expected_shape(spec, sizes)
    if array.shape != expected:
        symbols = shape_text(spec.shape)
        raise PackageError(f"{where}: expected shape {symbols} = {expected}, got {array.shape}")
    return array


def write_dataset(
    path: Path,
    group: h5py.Group,
    spec: DatasetSpec,
    value: Any,
    sizes: Mapping[str, int],
    *,
    compressed: bool = False,
) -> None:
    """Write a dataset with its unit, frame and meaning. Raises PackageError as `encoded` does."""
    array = encoded(f"{path}: {group.name}/{spec.path}", spec, value, sizes)
    packed: dict[str, Any] = {}
    if compressed and array.nbytes > WORTH_PACKING:
        packed = {"chunks": array.shape, "compression": "gzip", "shuffle": True}
    dataset = group.create_dataset(spec.path, data=array, dtype=array.dtype, **packed)
    for key in ("unit", "frame", "description"):
        set_text(dataset, key, getattr(spec, key))


def write_datasets(
    path: Path,
    group: h5py.Group,
    specs: Iterable[DatasetSpec],
    values: Mapping[str, Any],
    sizes: Mapping[str, int],
) -> None:
    """Write the datasets of a layout table that have a value, by path."""
    for spec in specs:
        if spec.path in values:
            write_dataset(path, group, spec, values[spec.path], sizes)


def read_datasets(group: h5py.Group, specs: Iterable[DatasetSpec]) -> dict[str, Any]:
    """Return the values of the existing datasets of a layout table, by path."""
    return {spec.path: read_dataset(group[spec.path], spec) for spec in specs if spec.path in group}


def check_datasets(
    where: str, specs: Iterable[DatasetSpec], values: Mapping[str, Any], sizes: Mapping[str, int]
) -> None:
    """Raise PackageError for the first value of a wrong type or shape; `where`: file and group."""
    for spec in specs:
        if spec.path in values:
            encoded(f"{where}/{spec.path}", spec, values[spec.path], sizes)


def declared_sizes(values: Mapping[str, Any], defining: Mapping[str, str]) -> dict[str, int]:
    """Return size by symbol, the length of the value that defines each."""
    return {symbol: len(values[path]) for symbol, path in defining.items() if path in values}


def read_dataset(dataset: h5py.Dataset, spec: DatasetSpec) -> Any:
    """Return the value of a dataset with checked type and shape."""
    if spec.type != "text":
        return np.asarray(dataset[()], dtype=spec.type)[()]
    if not spec.shape:
        return as_text(dataset[()])
    return tuple(as_text(text) for text in dataset[()])


def defined_sizes(group: h5py.Group, defining: Mapping[str, str]) -> dict[str, int]:
    """Return size by symbol, read from the first axis of the dataset that defines each."""
    return {
        symbol: group[path].shape[0]
        for symbol, path in defining.items()
        if isinstance(group.get(path), h5py.Dataset) and group[path].ndim > 0
    }


def missing_or_mistyped(group: h5py.Group, specs: Iterable[DatasetSpec]) -> list[Remark]:
    """Find missing datasets and datasets of a type that differs from the format."""
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
            text = f"missing; expected {spec.type} {shape_text(spec.shape)}{hint}"
            findings.append(Remark("error", where, text))
        elif is_text(item) != (spec.type == "text"):
            findings.append(Remark("error", where, f"expected {spec.type}, found {item.dtype}"))
        elif spec.type in ("int64", "uint8") and item.dtype.kind not in "iu":
            text = f"expected whole numbers ({spec.type}), found {item.dtype}"
            findings.append(Remark("error", where, text))
        elif spec.type == "float64" and item.dtype.kind not in "fiu":
            findings.append(Remark("error", where, f"expected float64, found {item.dtype}"))
        elif spec.shape and not item.ndim:
            text = f"expected shape {shape_text(spec.shape)}, found a single value"
            findings.append(Remark("error", where, text))
    return findings


def misshaped(
    group: h5py.Group, specs: Iterable[DatasetSpec], sizes: Mapping[str, int]
) -> list[Remark]:
    """Find datasets with shapes that differ from the sizes; unknown symbols are not checked.

    `missing_or_mistyped` finds single values in place of arrays.
    """
    known = {*sizes, *(("c+1",) if "c" in sizes else ())}
    findings = []
    for spec in specs:
        item = group.get(spec.path)
        symbols = {axis for axis in spec.shape if isinstance(axis, str)}
        if not isinstance(item, h5py.Dataset) or (spec.shape and not item.ndim):
            continue
        if not symbols <= known:
            continue
        expected = expected_shape(spec, sizes)
        if item.shape != expected:
            text = f"expected shape {shape_text(spec.shape)} = {expected}, found {item.shape}"
            findings.append(Remark("error", f"{group.name}/{spec.path}", text))
    return findings
