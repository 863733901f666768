"""The group /VTKHDF that ParaView reads: links to the data of the package."""

from typing import Any

import h5py
import numpy as np

from ...math.arrays import Array
from .container import set_text
from .findings import Remark

# Names in /VTKHDF and in the mesh of every format; the nodes have different names.
CELLS = (("Connectivity", "connectivity"), ("Offsets", "offsets"), ("Types", "cell_types"))


def create_grid(file: h5py.File, mesh: h5py.Group, nodes: str) -> h5py.Group:
    """Add /VTKHDF with hard links to a mesh, without a copy.

    Nodes of a plane mesh (n, 2) are shown in the plane x = 0: their columns are y and z.

    Parameters
    ----------
    file : open HDF5 file
    mesh : group of the mesh
    nodes : name of its nodes
    """
    view = file.create_group("VTKHDF")
    view.attrs["Version"] = np.array([2, 2], dtype=np.int64)
    view.attrs.create("Type", np.bytes_("UnstructuredGrid"), dtype="S16")
    if mesh[nodes].shape[1] == 3:
        view["Points"] = mesh[nodes]
    else:
        plane_view(view, "Points", mesh[nodes])
    for name, ours in CELLS:
        view[name] = mesh[ours]
    counts = (("Points", nodes), ("Cells", "cell_types"), ("ConnectivityIds", "connectivity"))
    for name, ours in counts:
        view[f"NumberOf{name}"] = np.array([len(mesh[ours])], dtype=np.int64)
    return view


def part_view(
    group: h5py.Group, name: str, of: h5py.Dataset, part: Any, shape: tuple[int, ...]
) -> h5py.Dataset:
    """Add a virtual dataset that shows `of[part]`.

    Parameters
    ----------
    group : group of the view
    name : name of the dataset
    of : dataset that is shown
    part : index of the part
    shape : shape of the part
    """
    return _virtual(group, name, of, part, shape, (0,) * len(shape))


def plane_view(group: h5py.Group, name: str, of: h5py.Dataset) -> h5py.Dataset:
    """Add a virtual dataset (n, 3) that shows vectors (n, 2) of the section, x1 = 0.

    Parameters
    ----------
    group : group of the view
    name : name of the dataset
    of : vectors (n, 2) of the section
    """
    return _virtual(group, name, of, ..., (of.shape[0], 3), (0, 1))


def _virtual(
    group: h5py.Group,
    name: str,
    of: h5py.Dataset,
    part: Any,
    shape: tuple[int, ...],
    corner: tuple[int, ...],
) -> h5py.Dataset:
    """Add a virtual dataset with `of[part]` from `corner` on and zeros before it.

    Uses the low-level interface of h5py; the high-level one would store the time of writing.
    """
    target = h5py.h5s.create_simple(shape)
    size = tuple(n - first for n, first in zip(shape, corner, strict=True))
    target.select_hyperslab(corner, size)
    source = h5py.VirtualSource(".", of.name, shape=of.shape, dtype=of.dtype)[part]
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_obj_track_times(False)
    creation.set_fill_value(np.zeros((), of.dtype))
    creation.set_virtual(target, b".", of.name.encode(), source.sel.id)
    made = h5py.h5d.create(
        group.id, name.encode(), of.id.get_type(), h5py.h5s.create_simple(shape), creation
    )
    return h5py.Dataset(made)


def describe(dataset: h5py.Dataset, unit: str, frame: str) -> None:
    """Give a dataset of the view its unit and frame.

    Parameters
    ----------
    dataset : dataset of the view
    unit : its unit
    frame : frame of its components
    """
    set_text(dataset, "unit", unit)
    set_text(dataset, "frame", frame)


def view_findings(file: h5py.File, mesh_path: str, nodes: str) -> list[Remark]:
    """Check that ParaView shows the mesh that this reader reads.

    Parameters
    ----------
    file : open HDF5 file
    mesh_path : path of the mesh
    nodes : name of its nodes
    """
    view = file.get("VTKHDF")
    if not isinstance(view, h5py.Group):
        return [Remark("warning", "/VTKHDF", "missing: ParaView cannot open the file")]
    mesh = file.get(mesh_path, {})
    findings = []
    for name, ours in (("Points", nodes), *CELLS):
        if name not in view:
            findings.append(Remark("warning", f"/VTKHDF/{name}", "missing"))
        elif ours in mesh and not np.array_equal(view[name][()], _in_space(mesh[ours][()])):
            text = f"differs from /{mesh_path}/{ours}"
            findings.append(Remark("error", f"/VTKHDF/{name}", text))
    return findings


def _in_space(values: Array) -> Array:
    plane = values.ndim == 2 and values.shape[1] == 2
    return np.pad(values, ((0, 0), (1, 0))) if plane else values
