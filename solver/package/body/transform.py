"""Other modes from those of a package: a change of basis, q = T q'.

All data of a package are sums over stations of products of shapes. A change of the modal
coordinates acts on each of their modal axes with T, exact to round-off. A subset of the modes, and
static shapes rebuilt as combinations of all modes, therefore need no new package (selection.py).
"""

from dataclasses import replace

import numpy as np

from ...math.arrays import Array
from ..common.dataset import mapped
from .schema import ModalPackage


def changed_basis(
    package: ModalPackage,
    T: Array,
    labels: tuple[str, ...] = (),
    kinds: tuple[str, ...] = (),
    damping: Array | None = None,
) -> ModalPackage:
    """Return the package in modal coordinates q', q = T q'.

    Parameters
    ----------
    T : (m, k), independent columns; k = 0 gives the rigid body with its true mass and inertia
    labels, kinds : k of the new modes; absent: those of the largest share of each column
    damping : (k, k) new modal damping; None: T' D T  [N m s]
    """
    m, k = T.shape
    if m != package.n_mode:
        raise ValueError(f"basis of {m} rows: expected {package.n_mode}, the modes of the package")
    if not k:
        places = (replace(place, H_B=None, H_psi_B=None) for place in package.interfaces)
        package = replace(package, interfaces=tuple(places), second_order=None)
    largest = np.argmax(np.abs(T), axis=0) if k else np.zeros(0, dtype=np.int64)
    some = np.array_equal(T, np.eye(m)[:, largest])  # of the modes, as they are

    def change(shape: str, A: Array) -> Array:
        axes = [axis for axis, size in enumerate(shape.split(", ")) if size == "m"]
        for axis in axes:
            if some:
                A = A.take(largest, axis)
            else:
                A = np.moveaxis(np.tensordot(A, T, (axis, 0)), -1, axis)
        if len(axes) == 4 and not some:
            A = 0.5 * (A + A.transpose(2, 3, 0, 1))  # to the last bit: the format asks it
        return np.ascontiguousarray(A) if axes else A

    found, known = mapped(package, change), package.mode_labels or package.mode_kinds
    return replace(
        found,
        mode_kinds=kinds or tuple(package.mode_kinds[i] for i in largest),
        mode_labels=labels or tuple(known[i] for i in largest),
        frequencies=np.sqrt(np.maximum(np.diag(found.stiffness), 0.0) / np.diag(found.mass)),
        damping=found.damping if damping is None else damping,
    )


def rigid(package: ModalPackage) -> ModalPackage:
    """Return the body without its modes: rigid, of the same mass and inertia."""
    return changed_basis(package, np.zeros((package.n_mode, 0)))
