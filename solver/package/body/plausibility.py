"""Plausibility of a package: checks across its datasets."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array
from ..common.finding import Finding
from .invariants import free_body_mass, inertia_at_rest
from .laminate_checks import laminate_findings
from .recovery_checks import recovery_findings
from .reference_checks import reference_findings
from .schema import Interface, ModalPackage

TOTAL_MASS = 1e-6  # relative: nodal masses against the invariants
CONSISTENCY = 1e-6  # relative: two values of the same quantity from one FE model
LUMPED_T11 = 0.05  # relative: lumped invariants against a modal mass that may be consistent


def plausibility_findings(package: ModalPackage) -> list[Finding]:
    """Return what is impossible (error) or suspicious (warning) in a body."""
    findings: list[Finding] = []
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


def _finding(level: str, dataset: str, message: str) -> Finding:
    return Finding(level, f"/modal_package/{dataset}", message)


def _eigenvalues(matrix: Array) -> Array:
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError("overflow")
    return np.asarray(np.linalg.eigvalsh(matrix), dtype=np.float64)


def _mass(package: ModalPackage) -> Iterator[Finding]:
    nodal, total = float(np.sum(package.node_mass)), package.invariants.mass
    if abs(nodal - total) > TOTAL_MASS * total:
        text = f"expected the sum of nodal/mass, {nodal:.9g} kg, found {total:.9g} kg"
        yield _finding("error", "invariants/mass", text)
    lumped = np.einsum("k,ka->a", package.node_mass, package.nodes_B)
    size = float(np.ptp(package.nodes_B, axis=0).max(initial=0.0)) or 1.0
    gap = float(np.abs(lumped - package.invariants.S0_B).max())
    if gap > 1e-2 * total * size:
        text = f"centre of mass is {gap / total:.3g} m from that of the nodal masses"
        yield _finding("warning", "invariants/S0_B", text)


def centre_inertia(package: ModalPackage) -> Array:
    """Inertia tensor of the undeformed body about its centre of mass, (3, 3) [kg m2]."""
    inv = package.invariants
    c = inv.S0_B / inv.mass
    return inertia_at_rest(inv) - inv.mass * (c @ c * np.eye(3) - np.outer(c, c))


def _inertia(package: ModalPackage) -> Iterator[Finding]:
    inv = package.invariants
    for name in ("T00_B", "J0_B"):
        matrix = getattr(inv, name)
        if np.abs(matrix - matrix.T).max() > 1e-9 * max(np.abs(inertia_at_rest(inv)).max(), 1e-300):
            yield _finding("error", f"invariants/{name}", "expected a symmetric matrix")
    a, b, c = _eigenvalues(centre_inertia(package))
    shown = f"principal inertias about the centre of mass are {a:.6g}, {b:.6g}, {c:.6g} kg m2"
    if a < -1e-9 * c:
        yield _finding("error", "invariants/T00_B", f"expected none below zero: {shown}")
    elif a <= 1e-12 * c:
        text = f"no inertia about one axis, so rotation about it is undetermined: {shown}"
        yield _finding("warning", "invariants/J0_B", text)
    if a + b < c * (1 - 1e-6):
        text = f"no body has this inertia, the two smaller must add up to the largest: {shown}"
        yield _finding("error", "invariants/T00_B", text)


def _free_body_mass(package: ModalPackage) -> Iterator[Finding]:
    M = free_body_mass(package)
    scale = np.sqrt(np.maximum(np.diag(M), 1e-300))
    smallest = float(_eigenvalues(M / np.outer(scale, scale))[0])
    if smallest < -CONSISTENCY:
        text = (
            "the mass matrix of frame and modes together is indefinite (scaled smallest "
            f"eigenvalue {smallest:.3g}): invariants and modal mass disagree"
        )
        yield _finding("error", "invariants/S_B", text)
    elif smallest < 1e-9 and "rigid" not in package.mode_kinds:
        text = "the modes contain a rigid-body motion: the mass matrix is singular"
        yield _finding("warning", "modes/shapes_B", text)


def _modal_mass(package: ModalPackage) -> Iterator[Finding]:
    """The translational part is at most the modal mass; the rest is rotary inertia."""
    translation = np.einsum("aaij->ij", package.invariants.T11_B)
    if not translation.size:
        return
    scale = np.sqrt(np.abs(np.diag(package.mass)))
    rest = (package.mass - translation) / np.outer(scale, scale)
    smallest = float(_eigenvalues((rest + rest.T) / 2)[0])
    lumped = package.invariants.mass_form == "lumped"
    if smallest < -(LUMPED_T11 if lumped else CONSISTENCY):
        text = (
            "its trace exceeds the modal mass: the rotary part would be negative "
            f"(scaled smallest eigenvalue {smallest:.3g})"
        )
        yield _finding("warning" if lumped else "error", "invariants/T11_B", text)


def _modes(package: ModalPackage) -> Iterator[Finding]:
    m = package.n_mode
    if not m:
        yield _finding("note", "modes/shapes_B", "no modes: the body is rigid")
        return
    gap = float(np.abs(package.mass - np.eye(m)).max())
    if gap > CONSISTENCY:
        text = f"modes are not orthonormal, X'MX - I is {gap:.3g}; the full matrix is used"
        yield _finding("note", "modes/mass", text)
    K = package.stiffness
    scale = np.sqrt(np.abs(np.diag(K)))
    scale[scale == 0] = 1.0
    smallest = float(_eigenvalues(K / np.outer(scale, scale))[0])
    if smallest < -1e-9:
        text = f"expected none of its eigenvalues below zero, smallest (scaled) is {smallest:.3g}"
        yield _finding("error", "modes/stiffness", text)
    if np.any(package.frequencies < 0):
        yield _finding("error", "modes/frequencies", "expected frequencies >= 0")
    found = np.sqrt(np.maximum(np.diag(K), 0) / np.diag(package.mass))
    for i, kind in enumerate(package.mode_kinds):
        known = package.frequencies[i]
        if kind == "fixed_normal" and abs(found[i] - known) > CONSISTENCY * max(found[i], known):
            text = (
                f"mode {i + 1}: {known:.9g} rad/s is given, "
                f"stiffness over mass gives {found[i]:.9g} rad/s"
            )
            yield _finding("warning", "modes/frequencies", text)


def _damping(package: ModalPackage) -> Iterator[Finding]:
    values = _eigenvalues(package.damping) if package.n_mode else np.zeros(1)
    if values[0] < -1e-9 * max(np.abs(values).max(), 1e-300):
        text = f"adds energy to the body (eigenvalue {values[0]:.3g})"
        yield _finding("warning", "modes/damping", text)


def _interface(package: ModalPackage, interface: Interface) -> Iterator[Finding]:
    where = f"interfaces/{interface.name}"
    row_of = {int(i): row for row, i in enumerate(package.node_ids)}
    rows = [row_of[int(i)] for i in interface.node_ids]
    w = interface.weights
    if abs(w.sum() - 1) > 1e-9:
        yield _finding("error", f"{where}/weights", f"expected sum 1, found {w.sum():.9g}")
        return
    size = float(np.ptp(package.nodes_B, axis=0).max(initial=0.0)) or 1.0
    gap = float(np.abs(w @ package.nodes_B[rows] - interface.position_B).max())
    if gap > CONSISTENCY * size:
        text = f"is {gap:.3g} m from the weighted position of its nodes"
        yield _finding("warning", f"{where}/position_B", text)
    mean = np.einsum("k,mkd->dm", w, package.shapes_B[:, rows])
    parts = [("phi_B", mean[:3])] + ([("psi_B", mean[3:])] if interface.kind == "node" else [])
    for name, expected in parts:
        gap = float(np.abs(getattr(interface, name) - expected).max(initial=0.0))
        part = package.shapes_B[:, :, :3] if name == "phi_B" else package.shapes_B[:, :, 3:]
        if gap > CONSISTENCY * np.abs(part).max(initial=0.0):
            text = f"differs by {gap:.3g} from the mode shapes of its nodes"
            yield _finding("error", f"{where}/{name}", text)


# In this order; then the checks of each interface and of the recovery.
CHECKS = (_mass, _inertia, _free_body_mass, _modal_mass, _modes, _damping, reference_findings)
