"""Write and read a modal package: HDF5, and a valid VTKHDF file (docs/format.md)."""

from pathlib import Path

import h5py
import numpy as np

from ..common.object_file import ObjectFormat, read_object, write_object
from ..common.remark import Remark, raise_first
from ..common.vtk_view import create_grid, describe, part_view
from .checks import content_findings
from .plausibility import plausibility_findings
from .schema import FORMAT, FORMAT_VERSION, ModalPackage


def _write_view(file: h5py.File, group: h5py.Group, package: ModalPackage) -> None:
    """Add /VTKHDF: the mesh and one virtual view per mode; no second copy."""
    shapes = group["modes/shapes_B"]
    point_data = create_grid(file, group["mesh"], "nodes_B").create_group("PointData")
    for i in range(package.n_mode):
        for label, unit, part in (("shape", "m", slice(0, 3)), ("rotation", "rad", slice(3, 6))):
            name, size = f"mode_{i + 1:03d}_{label}", (shapes.shape[1], 3)
            describe(part_view(point_data, name, shapes, np.s_[i, :, part], size), unit, "B")


MODAL_PACKAGE = ObjectFormat(
    FORMAT,
    FORMAT_VERSION,
    "modal_package",
    "body",
    ModalPackage,
    "a modal package",
    "nodes_B",
    content_findings,
    _write_view,
    plausibility_findings,
)


def write_package(path: str | Path, package: ModalPackage) -> None:
    """Write a modal package; see `write_object`."""
    write_object(path, MODAL_PACKAGE, package)


def read_package(path: str | Path, *, allow_doubtful: bool = False) -> ModalPackage:
    """Read a modal package and check that the solver can use it; see `read_object`.

    What `validate` calls an error is an error here.

    Parameters
    ----------
    allow_doubtful : numbers that can be computed with but contradict each other become warnings
        in the package's provenance
    """
    return read_object(path, MODAL_PACKAGE, _warn if allow_doubtful else None)


def _warn(package: ModalPackage, doubts: list[Remark]) -> None:
    stiffness = [d for d in doubts if d.dataset == "/modal_package/modes/stiffness"]
    raise_first(Path(package.body), stiffness)  # no step can be taken with it
    warnings = package.provenance.setdefault("warnings", [])
    warnings += [
        {"code": "package-doubtful", "message": f"{d.dataset}: {d.message}"} for d in doubts
    ]
