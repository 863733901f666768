"""Consistency of the modes of a package: mass, stiffness, damping, frequencies."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array
from ..common.remark import Remark
from .scales import critical_damping
from .schema import ModalPackage

CONSISTENCY = 1e-6  # relative: two results of the same FE model
LUMPED_T11 = 0.05  # relative: lumped invariants and a modal mass that may be consistent
OVERDAMPED = 100.0  # least damping ratio of a body: modes would creep, 200 times the period long
NEGATIVE = 1e-9  # eigenvalue of a stiffness of unit diagonal, damping ratio: above round-off


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


def _finding(level: str, dataset: str, message: str) -> Remark:
    return Remark(level, f"/modal_package/{dataset}", message)


def _modal_mass(package: ModalPackage) -> Iterator[Remark]:
    """The mass of translation is at most the modal mass; rotary inertia is the difference."""
    translation = np.einsum("aaij->ij", package.invariants.T11_B)
    scale = np.sqrt(np.abs(np.diag(package.mass)))
    rest = (package.mass - translation) / np.outer(scale, scale)
    smallest = float(eigenvalues((rest + rest.T) / 2)[0])
    lumped = package.invariants.mass_form == "lumped"
    if smallest < -(LUMPED_T11 if lumped else CONSISTENCY):
        text = (
            "its trace exceeds the modal mass: the rotary part would be negative "
            f"(scaled smallest eigenvalue {smallest:.3g})"
        )
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
    found = np.sqrt(np.maximum(np.diag(package.stiffness), 0) / np.diag(package.mass))
    for i, kind in enumerate(package.mode_kinds):
        known = package.frequencies[i]
        if kind == "fixed_normal" and abs(found[i] - known) > CONSISTENCY * max(found[i], known):
            text = (
                f"mode {i + 1}: {known:.9g} rad/s is given, "
                f"stiffness over mass gives {found[i]:.9g} rad/s"
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
