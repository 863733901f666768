"""Plausibility of a package: checks between its datasets."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array
from ...math.definite import smallest_eigenvalue
from ..common.array_checks import ROUNDING
from ..common.remark import Remark
from .invariants import free_body_mass, inertia_at_rest
from .laminate_checks import laminate_findings
from .mode_checks import CONSISTENCY, eigenvalues, mode_findings
from .recovery_checks import recovery_findings
from .reference_checks import reference_findings
from .scales import body_size, frame_mass_sizes, mode_motions
from .schema import Interface, ModalPackage

TOTAL_MASS = 1e-6  # relative: nodal masses against the invariants


def plausibility_findings(package: ModalPackage) -> list[Remark]:
    """Return impossible (error) and suspicious (warning) findings about a body."""
    findings: list[Remark] = []
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for check in CHECKS:
                findings += check(package)
    except np.linalg.LinAlgError as cause:
        text = f"eigenvalues cannot be computed, numbers are out of range ({cause})"
        findings.append(_finding("error", "modes", text))
    findings += recovery_findings(package)
    findings += laminate_findings(package)
    for interface in package.interfaces:
        findings += _interface(package, interface)
    return findings


def _finding(level: str, dataset: str, message: str) -> Remark:
    return Remark(level, f"/modal_package/{dataset}", message)


def _mass(package: ModalPackage) -> Iterator[Remark]:
    nodal, total = float(np.sum(package.node_mass)), package.invariants.mass
    if abs(nodal - total) > TOTAL_MASS * total:
        text = f"expected the sum of nodal/mass, {nodal:.9g} kg, found {total:.9g} kg"
        yield _finding("error", "invariants/mass", text)
    lumped = np.einsum("k,ka->a", package.node_mass, package.nodes_B)
    gap = float(np.abs(lumped - package.invariants.S0_B).max())
    if gap > 1e-2 * total * body_size(package):
        text = f"centre of mass is {gap / total:.3g} m from that of the nodal masses"
        yield _finding("warning", "invariants/S0_B", text)


def centre_inertia(package: ModalPackage) -> Array:
    """Inertia tensor of the undeformed body about its centre of mass, (3, 3) [kg m2]."""
    inv = package.invariants
    c = inv.S0_B / inv.mass
    return inertia_at_rest(inv) - inv.mass * (c @ c * np.eye(3) - np.outer(c, c))


def _inertia(package: ModalPackage) -> Iterator[Remark]:
    inv = package.invariants
    at_rest = float(np.abs(inertia_at_rest(inv)).max())
    for name in ("T00_B", "J0_B"):
        matrix = getattr(inv, name)
        if np.abs(matrix - matrix.T).max() > 1e-9 * at_rest:
            yield _finding("error", f"invariants/{name}", "expected a symmetric matrix")
    a, b, c = eigenvalues(centre_inertia(package))
    # if the body is far from the origin of B, the inertia about it and its round-off are larger
    rounding = ROUNDING * at_rest
    shown = f"principal inertias about the centre of mass are {a:.6g}, {b:.6g}, {c:.6g} kg m2"
    if a < -max(1e-9 * c, rounding):
        yield _finding("error", "invariants/T00_B", f"expected values >= 0: {shown}")
    elif a <= max(1e-12 * c, rounding):
        text = f"no inertia about one axis, the body cannot rotate about it alone: {shown}"
        yield _finding("warning", "invariants/J0_B", text)
    if a + b < c - max(1e-6 * c, rounding):
        text = f"impossible inertia, expected no value above the sum of the others: {shown}"
        yield _finding("error", "invariants/T00_B", text)


def _free_body_mass(package: ModalPackage) -> Iterator[Remark]:
    M = free_body_mass(package)
    smallest = smallest_eigenvalue(M, frame_mass_sizes(M))
    if smallest < -CONSISTENCY:
        text = (
            "the mass matrix of frame and modes together is indefinite (scaled smallest "
            f"eigenvalue {smallest:.3g}): invariants and modal mass disagree"
        )
        yield _finding("error", "invariants/S_B", text)
    elif smallest < 1e-9 and "rigid" not in package.mode_kinds:
        text = "the modes contain a rigid-body motion: the mass matrix is singular"
        yield _finding("warning", "modes/shapes_B", text)


def _interface(package: ModalPackage, interface: Interface) -> Iterator[Remark]:
    where = f"interfaces/{interface.name}"
    row_of = {int(i): row for row, i in enumerate(package.node_ids)}
    rows = [row_of[int(i)] for i in interface.node_ids]
    w = interface.weights
    if abs(w.sum() - 1) > 1e-9:
        yield _finding("error", f"{where}/weights", f"expected sum 1, found {w.sum():.9g}")
        return
    size = body_size(package)
    gap = float(np.abs(w @ package.nodes_B[rows] - interface.position_B).max())
    if gap > CONSISTENCY * size:
        text = f"is {gap:.3g} m from the weighted position of its nodes"
        yield _finding("warning", f"{where}/position_B", text)
    mean = np.einsum("k,mkd->dm", w, package.shapes_B[:, rows])
    displacement, rotation = (float(part.max(initial=0.0)) for part in mode_motions(package))
    parts = [("phi_B", mean[:3], max(displacement, size * rotation))]
    if interface.kind == "node":
        parts.append(("psi_B", mean[3:], max(rotation, displacement / size)))
    for name, expected, largest in parts:
        gap = float(np.abs(getattr(interface, name) - expected).max(initial=0.0))
        if gap > CONSISTENCY * largest:
            text = f"differs by {gap:.3g} from the mode shapes of its nodes"
            yield _finding("error", f"{where}/{name}", text)


# In this order; then the checks of each interface and of the recovery.
CHECKS = (_mass, _inertia, _free_body_mass, mode_findings, reference_findings)
