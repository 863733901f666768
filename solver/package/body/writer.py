"""Write a modal package: an HDF5 file that is also a valid VTKHDF file (docs/format.md)."""

from pathlib import Path

import h5py
import numpy as np

from ...errors import PackageError
from ..common.container import set_text
from ..common.dataset import write_dataset, write_datasets
from ..common.identity import json_text
from ..common.object_file import new_object_file
from ..common.remark import raise_first
from ..common.vtk_view import create_grid, describe, part_view
from ..section.recovery_data import RECOVERY_LAYOUT, recovery_sizes, recovery_values
from .checks import check_shapes, content_findings
from .laminate_data import CELL_LAYOUT, LAMINATE_LAYOUT, laminate_values
from .layout import (
    BODY_LAYOUT,
    BODY_RECOVERY_LAYOUT,
    INTERFACE_LAYOUT,
    MODAL_PACKAGE,
    SECTION_LAYOUT,
    body_sizes,
    body_values,
)
from .schema import ModalPackage
from .second_order import (
    INTERFACE_SECOND_ORDER_LAYOUT,
    SECOND_ORDER_LAYOUT,
    second_order_values,
)


def write_package(path: str | Path, package: ModalPackage) -> None:
    """Write a modal package under a temporary name, then rename it.

    Raises
    ------
    PackageError
        The package is inconsistent (shapes, NaN, symmetry, names). The
        message names file and dataset; nothing is written.
    """
    path = Path(path)
    check_shapes(path, package)
    raise_first(path, content_findings(package))
    with new_object_file(path, MODAL_PACKAGE, package.body, "a modal package") as (file, group):
        provenance = json_text(f"{path}: provenance", package.provenance)
        try:
            set_text(file, "provenance", provenance)
        except ValueError as cause:
            raise PackageError(f"{path}: provenance: {cause}") from cause
        _write_body(path, group, package)
        _write_view(file, group)


def _write_body(path: Path, group: h5py.Group, package: ModalPackage) -> None:
    set_text(group, "reference_condition", package.reference_condition)
    sizes, values = body_sizes(package), body_values(package)
    write_datasets(path, group, BODY_LAYOUT, values, sizes)
    set_text(group["invariants"], "mass_form", package.invariants.mass_form)
    for index, interface in enumerate(package.interfaces):
        sub = _named_group(path, group, "interfaces", interface.name, index)
        set_text(sub, "kind", interface.kind)
        for spec in INTERFACE_LAYOUT:
            k = {"k": len(interface.node_ids)}
            write_dataset(path, sub, spec, getattr(interface, spec.path), sizes | k)
        for spec in INTERFACE_SECOND_ORDER_LAYOUT if package.second_order else ():
            write_dataset(path, sub, spec, getattr(interface, spec.path), sizes)
    if package.second_order is not None:
        second = second_order_values(package.second_order)
        for spec in SECOND_ORDER_LAYOUT:
            write_dataset(path, group, spec, second[spec.path], sizes, compressed=True)
    for index, section in enumerate(package.sections):
        sub = _named_group(path, group, "sections", section.name, index)
        for spec in SECTION_LAYOUT:
            if getattr(section, spec.path) is not None:
                write_dataset(path, sub, spec, getattr(section, spec.path), sizes)
        if section.recovery is not None:
            packed = recovery_values(section.recovery, f"{path}: {sub.name}")
            for spec in RECOVERY_LAYOUT:
                value = packed[spec.path]
                write_dataset(path, sub, spec, value, recovery_sizes(packed), compressed=True)
    if package.recovery is not None:
        stations = sizes | {"s": len(package.recovery.station_x)}
        for spec in BODY_RECOVERY_LAYOUT:
            value = getattr(package.recovery, spec.path.split("/")[1])
            write_dataset(path, group, spec, value, stations, compressed=True)
    _write_laminates(path, group, package)


def _write_laminates(path: Path, group: h5py.Group, package: ModalPackage) -> None:
    for index, laminate in enumerate(package.laminates):
        sub = _named_group(path, group, "laminates", laminate.name, index)
        values = laminate_values(laminate, f"{path}: {sub.name}")
        for spec in LAMINATE_LAYOUT:
            plies = {"k": len(laminate.plies)}
            write_dataset(path, sub, spec, values[spec.path], plies, compressed=True)
    if package.cell_resultants is not None:
        sizes = {"e": len(package.cell_resultants.cell), "m": package.n_mode}
        for spec in CELL_LAYOUT:
            value = getattr(package.cell_resultants, spec.path.split("/")[1])
            write_dataset(path, group, spec, value, sizes, compressed=True)


def _write_view(file: h5py.File, group: h5py.Group) -> None:
    """Add /VTKHDF: the mesh and one virtual view per mode; no second copy."""
    shapes = group["modes/shapes_B"]
    point_data = create_grid(file, group["mesh"], "nodes_B").create_group("PointData")
    for i in range(shapes.shape[0]):
        for label, unit, part in (("shape", "m", slice(0, 3)), ("rotation", "rad", slice(3, 6))):
            name, size = f"mode_{i + 1:03d}_{label}", (shapes.shape[1], 3)
            describe(part_view(point_data, name, shapes, np.s_[i, :, part], size), unit, "B")


def _named_group(path: Path, group: h5py.Group, parent: str, name: str, index: int) -> h5py.Group:
    where = f"{path}: {group.name}/{parent}"
    if not name or name == "." or "/" in name or "\0" in name:
        raise PackageError(f"{where}: {name!r} is not a valid name (empty, '.', or with '/')")
    if f"{parent}/{name}" in group:
        raise PackageError(f"{where}: the name {name!r} occurs twice")
    sub = group.create_group(f"{parent}/{name}")
    sub.attrs["index"] = np.int64(index)
    return sub
