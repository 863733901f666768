"""Sizes of a body and of its modes: the scales of round-off in its data.

A sum over mass stations may be zero because its terms cancel. The result is then round-off of the
terms. A check must compare it with the size of the terms, not with the sum.
"""

import numpy as np

from ...math.arrays import Array
from .schema import ModalPackage


def body_size(package: ModalPackage) -> float:
    """Largest extent of the nodes along an axis of B [m]; 1 m for a single point."""
    return float(np.ptp(package.nodes_B, axis=0).max(initial=0.0)) or 1.0


def mode_motions(package: ModalPackage) -> tuple[Array, Array]:
    """Largest displacement [m] and rotation [rad] of any node per unit of each mode, (m,) both."""
    largest = np.abs(package.shapes_B).max(axis=1, initial=0.0)
    return largest[:, :3].max(axis=1, initial=0.0), largest[:, 3:].max(axis=1, initial=0.0)


def modal_mass_sizes(package: ModalPackage) -> Array:
    """Square root of the modal mass if the whole body moved like its fastest node, (m,)."""
    displacement, rotation = mode_motions(package)
    inv = package.invariants
    inertia = np.trace(inv.J0_B)
    return np.asarray(np.sqrt(np.abs(inv.mass * displacement**2 + inertia * rotation**2)))


def frame_mass_sizes(M: Array) -> Array:
    """Square root of the diagonal of `free_body_mass`; one size for the three rotations."""
    size = np.sqrt(np.abs(np.diagonal(M)))
    size[3:6] = size[3:6].max()
    return np.asarray(size)


def critical_damping(package: ModalPackage) -> Array:
    """2 sqrt(K_ii M_ii) of each mode, (m,) [N m s]."""
    product = np.diagonal(package.stiffness) * np.diagonal(package.mass)
    return np.asarray(2.0 * np.sqrt(np.maximum(product, 0.0)))


def second_order_sizes(package: ModalPackage) -> dict[str, float]:
    """Size of the terms of each second-order table, by the name of its dataset.

    A rotation r of a slender body displaces its points by up to size r^2 to second order.
    """
    displacement, rotation = (float(part.max(initial=0.0)) for part in mode_motions(package))
    reach = max(body_size(package), float(np.abs(package.nodes_B).max(initial=0.0)))
    turn = rotation**2 + (displacement / body_size(package)) ** 2
    h, mass = reach * turn, package.invariants.mass
    return {
        "Z0_B": mass * h,
        "Z1_B": mass * reach * h,
        "G3": mass * displacement * h,
        "G4": mass * h * h,
        "H_B": h,
        "H_psi_B": turn,
    }
