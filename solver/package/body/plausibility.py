"""Plausibility of a package: checks between its datasets, and of stresses against the modes."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array, is_positive_definite, smallest_eigenvalue
from ..common.cells import area_vectors, cell_table
from ..common.findings import ROUNDING, Remark
from ..section.stress import unit_resultants_findings
from .invariants import (
    body_size,
    critical_damping,
    frame_mass_sizes,
    free_body_mass,
    inertia_at_rest,
    mode_motions,
)
from .package_schema import CellResultants, Interface, LaminateData, ModalPackage

TOTAL_MASS = 1e-6  # relative: nodal masses against the invariants
CONSISTENCY = 1e-6  # relative: two results of the same FE model
LUMPED_T11 = 0.05  # relative: lumped invariants and a modal mass that may be consistent
LUMPED_WORDS = (
    ": it is a sum over nodes, because the mass matrix does not tell it exactly (docs/exchange.md, "
    "What is computed). Centrifugal and Coriolis forces of these modes have an error of this "
    "order, frequencies have none; a finer mesh makes it smaller"
)
OVERDAMPED = 100.0  # least damping ratio of a body: modes would creep, 200 times the period long
NEGATIVE = 1e-9  # eigenvalue of a stiffness of unit diagonal, damping ratio: above round-off
AT_REST = 1e-9  # motion of a reference node relative to the largest of its mode
MOMENTUM = 1e-6  # momentum of a mode with a mean axis, relative to that of its mass in rigid motion


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
    findings += stress_findings(package)
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


def mode_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return impossible or suspicious findings about the modes."""
    if not package.n_mode:
        yield _finding("note", "modes/shapes_B", "no modes: the body is rigid")
        return
    yield from _modal_mass(package)
    yield from _stiffness(package)
    yield from _frequencies(package)
    yield from _damping(package)


def eigenvalues(matrix: Array) -> Array:
    """Eigenvalues of a symmetric matrix, ascending. Raises LinAlgError if it is not finite."""
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError("overflow")
    return np.asarray(np.linalg.eigvalsh(matrix), dtype=np.float64)


def _modal_mass(package: ModalPackage) -> Iterator[Remark]:
    """The mass of translation is at most the modal mass; rotary inertia is the difference."""
    translation = np.einsum("aaij->ij", package.invariants.T11_B)
    scale = np.sqrt(np.abs(np.diag(package.mass)))
    rest = (package.mass - translation) / np.outer(scale, scale)
    smallest = float(eigenvalues((rest + rest.T) / 2)[0])
    lumped = package.invariants.mass_form == "lumped"
    if smallest < -(LUMPED_T11 if lumped else CONSISTENCY):
        share = np.diag(translation) / np.diag(package.mass)
        k = int(share.argmax())
        text = (
            f"the mass of translation (trace) exceeds the modal mass by {100 * share[k] - 100:.3g} "
            f"% in mode {k + 1} and by {-100 * smallest:.3g} % in a combination of modes"
        )
        text += LUMPED_WORDS if lumped else ": rotary inertia would be negative"
        yield _finding("warning" if lumped else "error", "invariants/T11_B", text)
    gap = float(np.abs(package.mass - np.eye(package.n_mode)).max())
    if gap > CONSISTENCY:
        text = f"modes are not orthonormal, X'MX - I is {gap:.3g}; the full matrix is used"
        yield _finding("note", "modes/mass", text)


def _stiffness(package: ModalPackage) -> Iterator[Remark]:
    """No eigenvalue below zero. That of a rigid motion is round-off of the elastic ones."""
    K, mass = package.stiffness, np.diag(package.mass)
    size, allowed = np.sqrt(np.abs(np.diag(K))), NEGATIVE
    rigid = np.array([kind == "rigid" for kind in package.mode_kinds])
    if rigid.all():
        return
    if rigid.any():
        softest = (size**2 / mass)[~rigid].min()
        size[rigid] = np.sqrt(softest * mass[rigid])
        allowed = CONSISTENCY
    size[size == 0.0] = 1.0
    smallest = float(eigenvalues(K / np.outer(size, size))[0])
    if smallest < -allowed:
        text = f"expected eigenvalues >= 0, the smallest (scaled) is {smallest:.3g}"
        yield _finding("error", "modes/stiffness", text)


def _frequencies(package: ModalPackage) -> Iterator[Remark]:
    if np.any(package.frequencies < 0):
        yield _finding("error", "modes/frequencies", "expected frequencies >= 0")
    omega = np.sqrt(np.maximum(np.diag(package.stiffness), 0) / np.diag(package.mass))
    for i, kind in enumerate(package.mode_kinds):
        known = package.frequencies[i]
        if kind == "fixed_normal" and abs(omega[i] - known) > CONSISTENCY * max(omega[i], known):
            text = (
                f"mode {i + 1}: {known:.9g} rad/s is given, "
                f"stiffness over mass gives {omega[i]:.9g} rad/s"
            )
            yield _finding("warning", "modes/frequencies", text)


def _damping(package: ModalPackage) -> Iterator[Remark]:
    """Damping ratios that a body can have. A mode without stiffness is compared with the others."""
    critical = critical_damping(package)
    largest = critical.max()
    size = np.sqrt(np.maximum(critical, 1e-6 * largest)) if largest else np.ones(package.n_mode)
    ratios = eigenvalues(package.damping / np.outer(size, size))
    if ratios[0] < -NEGATIVE * max(np.abs(ratios).max(), 1.0 if largest else 0.0):
        text = f"feeds energy into the body (smallest damping ratio {ratios[0]:.3g})"
        yield _finding("error", "modes/damping", text)
    elif largest and ratios[0] > OVERDAMPED:
        text = f"smallest damping ratio {ratios[0]:.3g}: expected less than {OVERDAMPED:g}"
        yield _finding("error", "modes/damping", text)


def reference_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return contradictions to the reference condition of a body with modes."""
    if not package.n_mode:
        return
    if package.reference_condition == "mean-axis":
        yield from _mean_axis(package)
        return
    # Largest motion of each node in any mode, (n, 6), relative to the largest of each mode.
    largest = np.abs(package.shapes_B).max(axis=(1, 2), keepdims=True)
    scaled = np.abs(package.shapes_B) / np.where(largest == 0.0, 1.0, largest)
    motion = np.asarray(scaled.max(axis=0))
    if package.reference_condition == "clamped":
        smallest = float(motion.max(axis=1).min())
        if smallest > AT_REST:
            text = f"reference condition is clamped, but every node moves (at least {smallest:.3g})"
            yield _finding("warning", "modes/shapes_B", text)
    elif package.reference_condition == "chord":
        across = motion[:, 1:3].max(axis=1) <= AT_REST
        origin = across & (motion[:, 0] <= AT_REST) & (motion[:, 3] <= AT_REST)
        if not origin.any() or np.count_nonzero(across) < 2:
            text = (
                "reference condition is chord: expected a node without displacement and twist and "
                "another without displacement across x, found "
                f"{np.count_nonzero(origin)} and {np.count_nonzero(across & ~origin)}"
            )
            yield _finding("warning", "modes/shapes_B", text)


def _mean_axis(package: ModalPackage) -> Iterator[Remark]:
    M = free_body_mass(package)
    size = np.sqrt(np.abs(np.diag(M)))
    size[3:6] = np.maximum(
        size[3:6], 1e-6 * size[3:6].max()
    )  # points on a line have no inertia about it
    momentum = np.abs(M[:6, 6:]) / np.outer(size[:6], size[6:])
    for rows, name, dataset in (
        (slice(0, 3), "linear", "S_B"),
        (slice(3, 6), "angular", "T01_B"),
    ):
        mode = int(np.argmax(momentum[rows].max(axis=0)))
        worst = float(momentum[rows, mode].max())
        if worst > MOMENTUM:
            text = (
                f"reference condition is mean-axis, but mode {mode + 1} has {name} momentum "
                f"({worst:.3g} of that of rigid motion)"
            )
            yield _finding("warning", f"invariants/{dataset}", text)


# In this order; then the checks of each interface and of the recovery.
CHECKS = (_mass, _inertia, _free_body_mass, mode_findings, reference_findings)


# Factors: the strain energy of mean resultants is less than the total; that of a mode of a beam is
# taken from a few stations, without distributed terms.
ENERGY = 2.0
NORMAL = 1e-3  # sine of the angle between a cell's normal and its e3
EQUILIBRIUM = 1e-6  # relative error of the integrated stresses of a unit resultant
FEW_POINTS = 1e-3  # the same of a beam, at the few points that are kept
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0  # quadrature over a ply, exact for quadratic stresses


def stress_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return suspicious findings about stresses of beams and shells."""
    yield from _beam(package)
    for laminate in package.laminates:
        yield from _equilibrium(laminate)
    if package.cell_resultants is not None:
        yield from _cells(package, package.cell_resultants)


def _beam(package: ModalPackage) -> Iterator[Remark]:
    """Return suspicious findings about stresses: sections in other units or axes than the body."""
    if package.recovery is None and all(s.recovery is None for s in package.sections):
        return
    for section in package.sections:
        if not is_positive_definite(section.K):
            path = f"/modal_package/sections/{section.name}/K"
            yield Remark("warning", path, "not positive definite: inconsistent with stresses")
            return
    for section in package.sections:
        if section.recovery is not None:
            path = f"/modal_package/sections/{section.name}/recovery/strain_M"
            yield from unit_resultants_findings(path, section.K, section.recovery, FEW_POINTS)
    yield from _beam_energy(package)


def _beam_energy(package: ModalPackage) -> Iterator[Remark]:
    """Compare F6' K^-1 F6 along the beam with the modal stiffness.

    Attachment modes are excluded: their change between a few stations, and the shear that a
    classical beam neglects, are a considerable part of their energy. Rigid motions are excluded
    too: their energy is round-off.
    """
    recovery = package.recovery
    if recovery is None or not package.n_mode:
        return
    S = np.array([np.linalg.inv(section.K) for section in package.sections])[recovery.section]
    density = (recovery.resultants_E * (S @ recovery.resultants_E)).sum(axis=1)
    lengths = np.diff(recovery.station_x)[:, None]
    energy = np.sum(0.5 * lengths * (density[:-1] + density[1:]), axis=0)
    stiffness = np.diag(package.stiffness)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(stiffness > 0.0, energy / stiffness, 1.0)
    left_out = np.array([kind in ("attachment", "rigid") for kind in package.mode_kinds])
    wrong = np.flatnonzero(~left_out & ((factor > ENERGY) | (factor < 1.0 / ENERGY)))
    if wrong.size:
        i = int(wrong[0])
        text = f"mode {i + 1}: their strain energy is {factor[i]:.3g} times that of modes/stiffness"
        yield Remark("warning", "/modal_package/recovery/resultants_E", text)


def _equilibrium(laminate: LaminateData) -> Iterator[Remark]:
    """Stresses of unit resultants, rotated to laminate axes and integrated over the plies."""
    back = np.zeros((6, 8))
    for ply, operator in zip(laminate.plies, laminate.stress_M, strict=True):
        z = np.array([ply.bottom, 0.5 * (ply.bottom + ply.top), ply.top])
        weight = SIMPSON * (ply.top - ply.bottom)
        in_plane = _turn(ply.angle_deg) @ operator[:, (0, 1, 5)]
        back[:3] += np.einsum("l,lij->ij", weight, in_plane)
        back[3:] += np.einsum("l,l,lij->ij", weight, z, in_plane)
    scale = np.sqrt(np.diag(laminate.ABD))
    gap = np.abs(back[:, :6] - np.eye(6)) * scale[None, :] / scale[:, None]
    if gap.max() > EQUILIBRIUM:
        i, j = (int(v) for v in np.unravel_index(np.argmax(gap), gap.shape))
        text = (
            f"the stresses of unit resultant {j + 1} integrate to {back[i, j]:.6g} of resultant "
            f"{i + 1}, expected {float(i == j):g}"
        )
        path = f"/modal_package/laminates/{laminate.name}/plies/stress_M"
        yield Remark("warning", path, text)


def _turn(angle_deg: float) -> Array:
    """Matrix that rotates stresses 11, 22, 12 of a ply to laminate axes, (3, 3)."""
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array(
        [[c * c, s * s, -2.0 * c * s], [s * s, c * c, 2.0 * c * s], [c * s, -c * s, c * c - s * s]]
    )


def _cells(package: ModalPackage, resultants: CellResultants) -> Iterator[Remark]:
    where = "/modal_package/cell_resultants"
    offsets = package.offsets
    if not np.isin(np.diff(offsets)[resultants.cell], (3, 4)).all():
        text = "some of these cells are neither triangles nor quadrilaterals"
        yield Remark("warning", f"{where}/cell", text)
        return
    cells = cell_table(package.connectivity, offsets, resultants.cell)
    vector = area_vectors(package.nodes_B, cells)
    area = np.linalg.norm(vector, axis=1)
    e3 = resultants.A_BE[:, :, 2]
    off = np.linalg.norm(np.cross(vector, e3), axis=1) > NORMAL * area
    if off.any():
        text = f"row {int(np.argmax(off))}: e3 is not normal to the cell"
        yield Remark("warning", f"{where}/A_BE", text)
    yield from _cell_energy(package, resultants, area)


def _cell_energy(
    package: ModalPackage, resultants: CellResultants, area: Array
) -> Iterator[Remark]:
    """The mean resultants of the cells cannot have more energy than the mode."""
    energy = np.zeros(package.n_mode)
    for row, laminate in enumerate(package.laminates):
        own = resultants.laminate == row
        S = np.zeros((8, 8))
        S[:6, :6], S[6:, 6:] = np.linalg.inv(laminate.ABD), np.linalg.inv(laminate.Ds)
        R = resultants.resultants_E[own]
        energy += np.einsum("cim,cim->m", R, area[own][:, None, None] * (S @ R))
    stiffness = np.diag(package.stiffness)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(stiffness > 0.0, energy / stiffness, 0.0)
    factor[[kind == "rigid" for kind in package.mode_kinds]] = 0.0  # both energies are round-off
    if package.n_mode and factor.max() > ENERGY:
        i = int(np.argmax(factor))
        text = f"mode {i + 1}: their strain energy is {factor[i]:.3g} times that of modes/stiffness"
        yield Remark("warning", "/modal_package/cell_resultants/resultants_E", text)
