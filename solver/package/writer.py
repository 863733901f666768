"""Write a modal package: HDF5 that is a valid VTKHDF file too (docs/format.md)."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .checks import content_findings, raise_first
from .container import content_sha256, new_file, set_text
from .layout import (
    BODY_LAYOUT,
    GROUP,
    INTERFACE_LAYOUT,
    SECTION_LAYOUT,
    DatasetSpec,
    body_sizes,
    body_values,
    expected_shape,
    shape_text,
)
from .schema import FORMAT, FORMAT_VERSION, ModalPackage, PackageError

UNITS = "SI"


def write_package(path: str | Path, package: ModalPackage) -> None:
    """Write a modal package; the file appears only when it is complete.

    Raises
    ------
    PackageError
        When the package is inconsistent (shapes, NaN, symmetry, names): the
        message names file and dataset, nothing is written.
    """
    path = Path(path)
    if path.suffix != ".vtkhdf":
        raise PackageError(f"{path}: a modal package ends in .vtkhdf (ParaView goes by the name)")
    raise_first(path, content_findings(package))
    with new_file(path) as file:
        set_text(file, "format", FORMAT)
        file.attrs["format_version"] = np.array(FORMAT_VERSION, dtype=np.int64)
        set_text(file, "body", package.body)
        set_text(file, "units", UNITS)
        try:
            set_text(file, "provenance", json.dumps(package.provenance, default=_plain))
        except (TypeError, ValueError) as cause:
            raise PackageError(f"{path}: provenance: {cause}") from cause
        group = file.create_group(GROUP)
        _write_body(path, group, package)
        _write_view(file, group)
        set_text(file, "content_sha256", content_sha256(group, package.body, UNITS))


def _write_body(path: Path, group: h5py.Group, package: ModalPackage) -> None:
    set_text(group, "reference_condition", package.reference_condition)
    sizes, values = body_sizes(package), body_values(package)
    for spec in BODY_LAYOUT:
        if spec.path in values:
            _write(path, group, spec, values[spec.path], sizes)
    set_text(group["invariants"], "mass_form", package.invariants.mass_form)
    for index, interface in enumerate(package.interfaces):
        sub = _named_group(path, group, "interfaces", interface.name, index)
        set_text(sub, "kind", interface.kind)
        for spec in INTERFACE_LAYOUT:
            k = {"k": len(interface.node_ids)}
            _write(path, sub, spec, getattr(interface, spec.path), sizes | k)
    for index, section in enumerate(package.sections):
        sub = _named_group(path, group, "sections", section.name, index)
        for spec in SECTION_LAYOUT:
            _write(path, sub, spec, getattr(section, spec.path), sizes)


def _write(
    path: Path, group: h5py.Group, spec: DatasetSpec, value: Any, sizes: dict[str, int]
) -> None:
    where = f"{path}: {group.name}/{spec.path}"
    if spec.type == "text":
        texts = [value] if isinstance(value, str) else list(value)
        raw = [text.encode("utf-8") for text in texts]
        width = max([1, *map(len, raw)])
        dtype: Any = h5py.string_dtype("utf-8", width)
        array: Any = np.array(raw if spec.shape else raw[0], dtype=dtype)
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
    dataset = group.create_dataset(spec.path, data=array, dtype=dtype)
    for key in ("unit", "frame", "description"):
        set_text(dataset, key, getattr(spec, key))


def _write_view(file: h5py.File, group: h5py.Group) -> None:
    """Add /VTKHDF: hard links to the mesh and one virtual view per mode; no second copy."""
    view = file.create_group("VTKHDF")
    view.attrs["Version"] = np.array([2, 2], dtype=np.int64)
    view.attrs.create("Type", np.bytes_("UnstructuredGrid"), dtype="S16")
    mesh, shapes = group["mesh"], group["modes/shapes_B"]
    links = (("Points", "nodes_B"), ("Connectivity", "connectivity"))
    for name, ours in (*links, ("Offsets", "offsets"), ("Types", "cell_types")):
        view[name] = mesh[ours]
    counts = (("Points", "nodes_B"), ("Cells", "cell_types"), ("ConnectivityIds", "connectivity"))
    for name, ours in counts:
        view[f"NumberOf{name}"] = np.array([len(mesh[ours])], dtype=np.int64)
    point_data = view.create_group("PointData")
    source = h5py.VirtualSource(".", shapes.name, shape=shapes.shape, dtype=shapes.dtype)
    for i in range(shapes.shape[0]):
        for label, unit, part in (("shape", "m", slice(0, 3)), ("rotation", "rad", slice(3, 6))):
            layout = h5py.VirtualLayout((shapes.shape[1], 3), dtype=shapes.dtype)
            layout[...] = source[i, :, part]
            dataset = point_data.create_virtual_dataset(f"mode_{i + 1:03d}_{label}", layout)
            set_text(dataset, "unit", unit)
            set_text(dataset, "frame", "B")


def _named_group(path: Path, group: h5py.Group, parent: str, name: str, index: int) -> h5py.Group:
    where = f"{path}: {group.name}/{parent}"
    if not name or name == "." or "/" in name or "\0" in name:
        raise PackageError(f"{where}: {name!r} is no usable name (empty, '.', or with '/')")
    if f"{parent}/{name}" in group:
        raise PackageError(f"{where}: the name {name!r} is there twice")
    sub = group.create_group(f"{parent}/{name}")
    sub.attrs["index"] = np.int64(index)
    return sub


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"cannot be written as JSON: {value!r}")
