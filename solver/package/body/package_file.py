"""Write, read and check a modal package: HDF5, and a valid VTKHDF file (docs/format.md).

The checks here are those of numbers that the solver needs, of a package with correct shapes;
plausibility.py has those between its datasets.
"""

from math import isfinite
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...math.arrays import Array, is_positive_definite
from ..common.dataset import all_values
from ..common.findings import (
    ROUNDING,
    SYMMETRY,
    Remark,
    Reporter,
    finite,
    mesh_cells,
    one_of,
    positive_definite,
    raise_first,
    rotations,
    rows_of,
    symmetric,
)
from ..common.object_file import ObjectFormat, read_object, write_object
from ..common.vtk_view import create_grid, describe, part_view
from ..section.stress import check_materials, check_plies, check_recovery
from .invariants import (
    body_size,
    critical_damping,
    modal_mass_at,
    modal_mass_sizes,
    second_order_sizes,
)
from .package_schema import (
    FORMAT,
    FORMAT_VERSION,
    MASS_FORMS,
    MODE_KINDS,
    REFERENCE_CONDITIONS,
    ModalPackage,
)
from .plausibility import plausibility_findings

INTERFACE_KINDS = ("node", "average")
SUMS = ("Z0_B", "Z1_B", "G3", "G4")  # of second order


def content_findings(package: ModalPackage) -> list[Remark]:
    """Check the numbers that the solver needs, of a package with correct shapes."""
    bad: list[Remark] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", f"/modal_package/{dataset}", message))

    for path, value in all_values(package).items():
        finite(path, value, error)
    _provenance(package.provenance, error)
    if bad:
        return bad  # the other checks would report the same error

    _stresses(package, error)
    largest_damping = float(critical_damping(package).max(initial=0.0))
    for name, scale in (("mass", 0.0), ("stiffness", 0.0), ("damping", largest_damping)):
        symmetric(f"modes/{name}", getattr(package, name), error, scale)
    positive_definite("modes/mass", package.mass, error, modal_mass_sizes(package))
    if np.any(np.asarray(package.node_mass) < 0):
        row = int(np.argmin(package.node_mass))
        error("nodal/mass", f"expected masses >= 0, row {row} is {package.node_mass[row]:.6g} kg")
    if not package.invariants.mass > 0:
        error("invariants/mass", f"expected a mass > 0, found {package.invariants.mass:.6g} kg")

    one_of("modes/kinds", package.mode_kinds, MODE_KINDS, error)
    one_of("reference_condition", [package.reference_condition], REFERENCE_CONDITIONS, error)
    one_of("invariants/mass_form", [package.invariants.mass_form], MASS_FORMS, error)
    mesh_cells(package.offsets, package.connectivity, len(package.nodes_B), error)
    known = set(np.asarray(package.node_ids).tolist())
    if len(known) != len(package.node_ids):
        error("mesh/node_ids", "expected unique identifiers, found duplicates")
    for interface in package.interfaces:
        where = f"interfaces/{interface.name}"
        one_of(f"{where}/kind", [interface.kind], INTERFACE_KINDS, error)
        unknown = sorted(set(np.asarray(interface.node_ids).tolist()) - known)
        if unknown:
            error(f"{where}/node_ids", f"no node has the identifier {unknown[0]}")
        rotations(f"{where}/A_BI", interface.A_BI, error)
    _second_order(package, error)
    if package.stiffness_error is not None:
        symmetric("modes/stiffness_error", package.stiffness_error, error)
    if package.compliance is not None:
        wanted = 6 * len(package.interfaces) + 12
        if len(package.compliance) != wanted:
            error("modes/compliance", f"expected {wanted} loads, found {len(package.compliance)}")
        symmetric("modes/compliance", package.compliance, error)
    return bad


def _stresses(package: ModalPackage, error: Reporter) -> None:
    """Report sections, stations, laminates and resultants of cells that cannot be used."""
    for section in package.sections:
        if section.end_compliance is not None:
            path = f"sections/{section.name}/end_compliance"
            symmetric(path, section.end_compliance, error)
        if section.recovery is not None:
            check_recovery(section.recovery, f"sections/{section.name}/", error)
    if (stations := package.recovery) is not None:
        if np.any(np.diff(stations.station_x) < 0.0):
            error("recovery/station_x", "expected positions in ascending order")
        rows_of("recovery/section", stations.section, len(package.sections), error)
        rotations("recovery/A_BE", stations.A_BE, error)
    for laminate in package.laminates:
        where = f"laminates/{laminate.name}/"
        for name in ("ABD", "Ds"):
            symmetric(f"{where}{name}", getattr(laminate, name), error)
            positive_definite(f"{where}{name}", getattr(laminate, name), error)
        flat = [row for row, ply in enumerate(laminate.plies) if ply.top <= ply.bottom]
        if flat:
            text = f"row {flat[0]}: expected a height above that of plies/bottom"
            error(f"{where}plies/top", text)
        check_plies(laminate, "laminate", where, error)
    if (cells := package.cell_resultants) is not None:
        rows_of("cell_resultants/cell", cells.cell, len(package.cell_types), error)
        rows_of("cell_resultants/laminate", cells.laminate, len(package.laminates), error)
        rotations("cell_resultants/A_BE", cells.A_BE, error)
    if (faces := package.face_stresses) is not None:
        rows_of("face_stresses/cell", faces.cell, len(package.cell_types), error)
        rows_of("face_stresses/material", faces.material, len(faces.materials), error)
        rotations("face_stresses/A_BM", faces.A_BM, error)
        check_materials(faces, "face_stresses/", error)


def _provenance(table: Any, error: Reporter) -> None:
    """Report entries of `provenance` that are not of the documented form."""
    warnings, seconds = table.get("warnings", []), table.get("seconds", {})
    if not isinstance(warnings, list) or not all(map(_is_warning, warnings)):
        error("provenance", "warnings: expected a list of tables with the texts code and message")
    numbers = seconds.values() if isinstance(seconds, dict) else [None]
    if not all(_is_number(number) for number in numbers):
        error("provenance", "seconds: expected a table of numbers")


def _is_warning(item: Any) -> bool:
    return isinstance(item, dict) and all(
        isinstance(item.get(key), str) for key in ("code", "message")
    )


def _is_number(number: Any) -> bool:
    return isinstance(number, int | float) and not isinstance(number, bool) and isfinite(number)


def _second_order(package: ModalPackage, error: Reporter) -> None:
    """Report second-order data that the solver cannot use."""
    second = package.second_order
    if second is None:
        for interface in package.interfaces:
            if interface.H_B is not None:
                where = f"interfaces/{interface.name}/H_B"
                error(where, "needs the group second_order, which the body does not have")
        return
    tables = {f"second_order/{name}": getattr(second, name) for name in SUMS}
    if second.pieces is not None:
        if not (second.pieces.mass > 0.0).all():
            error("second_order/pieces/mass", "expected positive masses")
        tables["second_order/pieces/h_B"] = second.pieces.h_B
    for interface in package.interfaces:
        for name in ("H_B", "H_psi_B"):
            path = f"interfaces/{interface.name}/{name}"
            if getattr(interface, name) is None:
                error(path, "missing: a body with second_order needs it at every interface")
            else:
                tables[path] = getattr(interface, name)
    sizes, seen = second_order_sizes(package), _Count(error)
    for path, value in tables.items():
        _symmetric_modes(path, value, sizes[path.rpartition("/")[2]], seen)
    if not seen.count and package.n_mode:
        _exchange(second.G4, sizes["G4"], error)
        _definite(package, error)


class _Count:
    """A reporter that counts its calls."""

    def __init__(self, error: Reporter) -> None:
        self.count, self._error = 0, error

    def __call__(self, dataset: str, message: str) -> None:
        self.count += 1
        self._error(dataset, message)


def _symmetric_modes(path: str, value: Array, size: float, error: Reporter) -> None:
    """Report a table that changes if its last two modes are exchanged.

    `size` is that of the terms of its sums, because the terms may cancel: in a mean-axis frame Z0_B
    is round-off.
    """
    if not value.size:
        return
    gap = np.abs(value - np.swapaxes(value, -1, -2))
    if gap.max() > max(SYMMETRY * np.abs(value).max(), ROUNDING * size):
        i, j = (int(k) for k in np.unravel_index(np.argmax(gap), gap.shape)[-2:])
        error(
            path,
            f"expected symmetry in its last two modes, [{i}, {j}] and [{j}, {i}] differ by "
            f"{gap.max():.3g}",
        )


def _exchange(G4: Array, size: float, error: Reporter) -> None:
    """Report a G4 that changes if its two pairs of modes are exchanged."""
    gap = np.abs(G4 - G4.transpose(2, 3, 0, 1)).max()
    if gap > max(SYMMETRY * np.abs(G4).max(), ROUNDING * size):
        error("second_order/G4", f"expected [i, j, k, l] = [k, l, i, j], they differ by {gap:.3g}")


def _definite(package: ModalPackage, error: Reporter) -> None:
    """Report a modal mass that is not positive definite in a deformed body.

    Checks each mode and some combinations, with amplitudes that rotate an interface by a tenth of a
    radian or move it by a tenth of the size of the body.
    """
    m = package.n_mode
    if not is_positive_definite(package.mass):
        return  # reported for modes/mass
    size = body_size(package)
    mixed = np.sin(np.outer(np.arange(1, 5), np.arange(1, m + 1) ** 2))
    for direction in (*np.eye(m), *mixed):
        motion = [np.linalg.norm(i.phi_B @ direction) / size for i in package.interfaces]
        motion += [np.linalg.norm(i.psi_B @ direction) for i in package.interfaces]
        largest = float(max(motion, default=0.0))
        if largest == 0.0:
            continue
        for q in (0.1 / largest * direction, -0.1 / largest * direction):
            seen = _Count(error)
            positive_definite("second_order/G4", modal_mass_at(package, q), seen)
            if seen.count:
                return


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
