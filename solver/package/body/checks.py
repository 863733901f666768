"""Checks that a package must pass before the solver uses it: layout and numbers."""

from pathlib import Path

import h5py
import numpy as np

from ..common.array_checks import (
    finite,
    mesh_cells,
    one_of,
    positive_definite,
    rotations,
    symmetric,
)
from ..common.dataset import defined_sizes, encoded, misshaped, missing_or_mistyped
from ..common.remark import Remark
from ..section.recovery_checks import check_recovery
from ..section.recovery_data import RECOVERY_LAYOUT, RECOVERY_SIZED_BY
from .laminate_checks import check_cells, check_laminate
from .laminate_data import CELL_LAYOUT, CELL_SIZED_BY, LAMINATE_LAYOUT, LAMINATE_SIZED_BY
from .layout import (
    BODY_LAYOUT,
    BODY_RECOVERY_LAYOUT,
    GROUP,
    INTERFACE_LAYOUT,
    SECTION_LAYOUT,
    body_sizes,
    body_values,
)
from .provenance_checks import check_provenance
from .recovery_checks import check_stations
from .scales import critical_damping, modal_mass_sizes
from .schema import MASS_FORMS, MODE_KINDS, REFERENCE_CONDITIONS, ModalPackage
from .second_order import (
    INTERFACE_SECOND_ORDER_LAYOUT,
    SECOND_ORDER_LAYOUT,
    check_second_order,
    second_order_values,
)

INTERFACE_KINDS = ("node", "average")
SIZED_BY = {
    "n": "mesh/nodes_B",
    "c": "mesh/cell_types",
    "i": "mesh/connectivity",
    "m": "modes/shapes_B",
}


def layout_findings(group: h5py.Group) -> list[Remark]:
    """Compare the datasets of /modal_package with the format: presence, type, shape."""
    findings = missing_or_mistyped(group, BODY_LAYOUT)
    sizes = defined_sizes(group, SIZED_BY)
    findings += misshaped(group, BODY_LAYOUT, sizes)
    for parent, specs, count in (
        ("interfaces", INTERFACE_LAYOUT, {"k": "node_ids"}),
        ("sections", SECTION_LAYOUT, {}),
        ("laminates", LAMINATE_LAYOUT, LAMINATE_SIZED_BY),
    ):
        for name in group.get(parent, ()):
            sub = group[parent][name]
            if not isinstance(sub, h5py.Group):
                findings.append(Remark("error", sub.name, "expected a group"))
                continue
            findings += missing_or_mistyped(sub, specs)
            findings += misshaped(sub, specs, sizes | defined_sizes(sub, count))
            if parent == "interfaces" and "second_order" in group:
                findings += missing_or_mistyped(sub, INTERFACE_SECOND_ORDER_LAYOUT)
                findings += misshaped(sub, INTERFACE_SECOND_ORDER_LAYOUT, sizes)
            if parent == "sections" and "recovery" in sub:
                findings += missing_or_mistyped(sub, RECOVERY_LAYOUT)
                findings += misshaped(sub, RECOVERY_LAYOUT, defined_sizes(sub, RECOVERY_SIZED_BY))
    if "second_order" in group:
        findings += missing_or_mistyped(group, SECOND_ORDER_LAYOUT)
        findings += misshaped(group, SECOND_ORDER_LAYOUT, sizes)
    if "recovery" in group:
        findings += missing_or_mistyped(group, BODY_RECOVERY_LAYOUT)
        stations = sizes | defined_sizes(group, {"s": "recovery/station_x"})
        findings += misshaped(group, BODY_RECOVERY_LAYOUT, stations)
    if "cell_resultants" in group:
        findings += missing_or_mistyped(group, CELL_LAYOUT)
        cells = sizes | defined_sizes(group, CELL_SIZED_BY)
        findings += misshaped(group, CELL_LAYOUT, cells)
    return findings


def check_shapes(path: Path, package: ModalPackage) -> None:
    """Raise PackageError for the first array of the body of a wrong type or shape."""
    sizes, values = body_sizes(package), body_values(package)
    layout = BODY_LAYOUT
    if package.second_order is not None:
        values |= second_order_values(package.second_order)
        layout += SECOND_ORDER_LAYOUT
    for spec in layout:
        if spec.path in values:
            encoded(f"{path}: /{GROUP}/{spec.path}", spec, values[spec.path], sizes)


def content_findings(package: ModalPackage) -> list[Remark]:
    """Check the numbers that the solver needs, of a package with correct shapes."""
    bad: list[Remark] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", f"/modal_package/{dataset}", message))

    for path, value in body_values(package).items():
        finite(path, value, error)
    for interface in package.interfaces:
        for name in ("weights", "position_B", "A_BI", "phi_B", "psi_B"):
            finite(f"interfaces/{interface.name}/{name}", getattr(interface, name), error)
    for section in package.sections:
        for name in ("K", "M"):
            finite(f"sections/{section.name}/{name}", getattr(section, name), error)
        if section.end_compliance is not None:
            path = f"sections/{section.name}/end_compliance"
            finite(path, section.end_compliance, error)
            symmetric(path, section.end_compliance, error)
        if section.recovery is not None:
            check_recovery(section.recovery, f"sections/{section.name}/", error)
    if package.recovery is not None:
        check_stations(package.recovery, len(package.sections), error)
    for laminate in package.laminates:
        check_laminate(laminate, f"laminates/{laminate.name}/", error)
    if package.cell_resultants is not None:
        n_laminate, n_cell = len(package.laminates), len(package.cell_types)
        check_cells(package.cell_resultants, n_laminate, n_cell, error)
    check_provenance(package.provenance, error)
    if bad:
        return bad  # the other checks would report the same error

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
    check_second_order(package, error)
    return bad
