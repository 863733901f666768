"""Check that the shapes of a package fulfil its reference condition."""

from collections.abc import Iterator

import numpy as np

from ...math.arrays import Array
from ..common.remark import Remark
from .invariants import free_body_mass
from .schema import ModalPackage

AT_REST = 1e-9  # motion of a reference node relative to the largest of its mode
MOMENTUM = 1e-6  # momentum of a mode with a mean axis, relative to that of its mass in rigid motion


def reference_findings(package: ModalPackage) -> Iterator[Remark]:
    """Return contradictions to the reference condition of a body with modes."""
    if not package.n_mode:
        return
    if package.reference_condition == "mean-axis":
        yield from _mean_axis(package)
        return
    motion = _relative_motion(package)
    if package.reference_condition == "clamped":
        smallest = float(motion.max(axis=1).min())
        if smallest > AT_REST:
            text = f"reference condition is clamped, but every node moves (at least {smallest:.3g})"
            yield _finding("modes/shapes_B", text)
    elif package.reference_condition == "chord":
        across = motion[:, 1:3].max(axis=1) <= AT_REST
        origin = across & (motion[:, 0] <= AT_REST) & (motion[:, 3] <= AT_REST)
        if not origin.any() or np.count_nonzero(across) < 2:
            text = (
                "reference condition is chord: expected a node without displacement and twist and "
                "another without displacement across x, found "
                f"{np.count_nonzero(origin)} and {np.count_nonzero(across & ~origin)}"
            )
            yield _finding("modes/shapes_B", text)


def _finding(dataset: str, message: str) -> Remark:
    return Remark("warning", f"/modal_package/{dataset}", message)


def _relative_motion(package: ModalPackage) -> Array:
    """Largest motion of each node in any mode, (n, 6), relative to the largest of each mode."""
    largest = np.abs(package.shapes_B).max(axis=(1, 2), keepdims=True)
    scaled = np.abs(package.shapes_B) / np.where(largest == 0.0, 1.0, largest)
    return np.asarray(scaled.max(axis=0))


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
            yield _finding(f"invariants/{dataset}", text)
