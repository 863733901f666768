"""Other modes from those of a package: a change of basis, q = T q'.

All data of a package are sums over stations of products of shapes. A change of the modal
coordinates acts on each of their modal axes with T, exact to round-off. A subset of the modes, and
static shapes rebuilt as combinations of all modes, therefore need no new package (selection.py).
"""

from dataclasses import replace

import numpy as np

from ...math.arrays import Array
from .schema import BodyRecovery, Interface, ModalPackage, SecondOrder


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
    mass, stiffness = T.T @ package.mass @ T, T.T @ package.stiffness @ T
    inv = package.invariants
    largest = np.argmax(np.abs(T), axis=0) if k else np.zeros(0, dtype=np.int64)
    known = package.mode_labels or package.mode_kinds
    return replace(
        package,
        shapes_B=np.ascontiguousarray(np.tensordot(T.T, package.shapes_B, 1)),
        mode_kinds=kinds or tuple(package.mode_kinds[i] for i in largest),
        mode_labels=labels or tuple(known[i] for i in largest),
        frequencies=np.sqrt(np.maximum(np.diag(stiffness), 0.0) / np.diag(mass)),
        mass=mass,
        stiffness=stiffness,
        damping=T.T @ package.damping @ T if damping is None else damping,
        invariants=replace(
            inv,
            S_B=inv.S_B @ T,
            T01_B=inv.T01_B @ T,
            T11_B=_both(inv.T11_B, T),
            J_psi_B=inv.J_psi_B @ T,
        ),
        interfaces=tuple(_interface(place, T) for place in package.interfaces),
        recovery=_recovery(package.recovery, T),
        cell_resultants=None
        if package.cell_resultants is None
        else replace(
            package.cell_resultants, resultants_E=package.cell_resultants.resultants_E @ T
        ),
        second_order=None if not k else _second_order(package.second_order, T),
    )


def rigid(package: ModalPackage) -> ModalPackage:
    """Return the body without its modes: rigid, of the same mass and inertia."""
    return changed_basis(package, np.zeros((package.n_mode, 0)))


def _both(A: Array, T: Array) -> Array:
    """T' A T on the last two axes."""
    return np.asarray(np.ascontiguousarray(T.T @ A @ T))


def _interface(place: Interface, T: Array) -> Interface:
    second = place.H_B is not None and place.H_psi_B is not None and T.shape[1] > 0
    return replace(
        place,
        phi_B=place.phi_B @ T,
        psi_B=place.psi_B @ T,
        H_B=_both(place.H_B, T) if second and place.H_B is not None else None,
        H_psi_B=_both(place.H_psi_B, T) if second and place.H_psi_B is not None else None,
    )


def _recovery(found: BodyRecovery | None, T: Array) -> BodyRecovery | None:
    return None if found is None else replace(found, resultants_E=found.resultants_E @ T)


def _second_order(second: SecondOrder | None, T: Array) -> SecondOrder | None:
    if second is None:
        return None
    rows = np.argmax(T, axis=0)
    if np.array_equal(T, np.eye(len(T))[:, rows]):  # some of the modes, as they are
        G4 = second.G4[np.ix_(rows, rows, rows, rows)]
    else:
        inner = np.einsum("ijkl,ka,lb->ijab", second.G4, T, T, optimize=True)
        G4 = np.einsum("ijab,ic,jd->cdab", inner, T, T, optimize=True)
        G4 = 0.5 * (G4 + G4.transpose(2, 3, 0, 1))  # symmetric to the last bit: the format asks it
    return SecondOrder(
        Z0_B=_both(second.Z0_B, T),
        Z1_B=_both(second.Z1_B, T),
        G3=np.ascontiguousarray(np.tensordot(T.T, _both(second.G3, T), 1)),
        G4=np.ascontiguousarray(G4),
    )
