"""Second-order displacements of the modes, and their effect on the inertia of a body.

To second order a mass station moves with the modes to x + phi q + 1/2 q' h q. A bent beam
shortens, which the linear shapes neglect. This is equivalent to the geometric stiffness: for any
load f, sum f_k h_ij,k = -X_i' K_geo(f) X_j with the stresses of f (docs/stiffening.md).
"""

import numpy as np

from ...math.arrays import Array
from .schema import ModalPackage, SecondOrder

MOST_MODES = 40  # G4 has m^4 numbers; bodies with more modes have no second-order data


def second_order_from_stations(m: Array, x_B: Array, phi_B: Array, h_B: Array) -> SecondOrder:
    """Sum mass stations into the second-order invariants.

    Parameters
    ----------
    m, x_B, phi_B : as in `from_stations`, of the same stations
    h_B : (k, 3, n_mode, n_mode) second-order translation of the mass centres [m]
    """
    n = phi_B.shape[2]
    weighted = m[:, None, None, None] * h_B
    flat = h_B.reshape(-1, n * n)
    G4 = weighted.reshape(-1, n * n).T @ flat
    return SecondOrder(
        Z0_B=weighted.sum(axis=0),
        Z1_B=np.einsum("ka,kbij->abij", x_B, weighted, optimize=True),
        G3=(phi_B.reshape(-1, n).T @ weighted.reshape(-1, n * n)).reshape(n, n, n),
        G4=(0.5 * (G4 + G4.T)).reshape(n, n, n, n),
    )


def modal_mass_at(package: ModalPackage, q: Array) -> Array:
    """Modal mass of the body deformed by q (m,), (m, m): a sum over stations, so never negative."""
    second = package.second_order
    if second is None:
        return package.mass
    linear = second.G3 @ q
    bent = np.tensordot(second.G4 @ q, q, axes=(1, 0))  # G4[i, k, j, l] q[k] q[l]
    return np.asarray(package.mass + linear + linear.T + bent)
