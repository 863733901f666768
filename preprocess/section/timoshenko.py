"""The 6x6 stiffness of a beam of any section: exact Saint-Venant energy.

Strains e6 = [gamma11, 2 gamma12, 2 gamma13, kappa1, kappa2, kappa3] with
2 gamma12 = v' - phi3 and 2 gamma13 = w' + phi2; resultants F6 = K e6 =
[F1, F2, F3, M1, M2, M3] with M2 = integral of x3 sigma11 and M3 = -integral of
x2 sigma11, all about the origin of the section axes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...solver.package.schema import Array
from .forms import SectionMatrices, SectionSpace
from .mesh import SectionError
from .warping import (
    WarpingSolver,
    beam_strain_fields,
    classical_warping,
    shear_load,
    shear_warping,
)

CLASSICAL = np.array([0, 3, 4, 5])  # extension, twist, bend2, bend3
SHEAR = np.array([1, 2])

# Equilibrium along the beam, M2' = F3 and M3' = -F2: [F1, M1, M2, M3]' = Q [F2, F3].
Q = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])


@dataclass(frozen=True)
class SectionStiffness:
    """Stiffness of a section and the warpings that it came from."""

    K: Array  # (6, 6), order extension, shear2, shear3, twist, bend2, bend3 [N, N m, N m2]
    A: Array  # (4, 4) classical stiffness
    V0: Array  # (n_dof, 4) warping per unit classical strain
    V1: Array  # (n_dof, 2) warping per unit shear force


def classical_stiffness(matrices: SectionMatrices, Psi: Array, V0: Array) -> Array:
    """A (4, 4): [F1, M1, M2, M3] = A [gamma11, kappa1, kappa2, kappa3] without shear force.

    Paper: Eq. (44), without its factor 2, which would give 0.654 of the axial stiffness of an
    isotropic bar (nu = 0.3).
    """
    A = Psi.T @ (matrices.L @ Psi) + V0.T @ (matrices.H @ Psi)
    return 0.5 * (A + A.T)


def shear_compliance(
    matrices: SectionMatrices, Psi: Array, V0: Array, V1: Array, A: Array, T: Array
) -> tuple[Array, Array]:
    """Compliance G^-1 (2, 2) of pure shear and the coupling B (4, 4).

    B = V0' H V0 + Psi' L V0 and G^-1 = C2 - T' B' A^-1 B T, where C2 is the energy quadratic in
    the shear forces. Paper: Eq. (45), completed by the terms of Psi and by -B' A^-1 B, without
    which the shear stiffness is wrong by an order of magnitude.
    """
    H, L = matrices.H, matrices.L
    B = V0.T @ (H @ V0) + Psi.T @ (L @ V0)
    mixed = V1.T @ (H @ (V0 @ T))
    C2 = V1.T @ shear_load(matrices, Psi, V0, T) + mixed + mixed.T + T.T @ (V0.T @ (L @ V0)) @ T
    BT = B @ T
    compliance = C2 - BT.T @ np.linalg.solve(A, BT)
    return 0.5 * (compliance + compliance.T), B


def stiffness(
    space: SectionSpace, matrices: SectionMatrices, pins: NDArray[np.int64] | None = None
) -> SectionStiffness:
    """The 6x6 stiffness K of a section.

    Paper: Eq. (36), Eq. (41), Eq. (42), Eq. (43), with the blocks X = K[CLASSICAL, CLASSICAL],
    F = K[CLASSICAL, SHEAR] = -B' T G and G = K[SHEAR, SHEAR].

    Parameters
    ----------
    space, matrices : the section's mesh and its E, H, L
    pins : four unknowns to pin instead of the default ones (the result does not depend on them)

    Raises
    ------
    SectionError : a load on the warping that works on rigid motions, or K not positive definite.
    FactorisationError : E singular beyond its rigid motions (a disconnected section).
    """
    Psi = beam_strain_fields(space)
    solver = WarpingSolver(space, matrices.E, pins)
    V0 = classical_warping(solver, matrices, Psi)
    A = classical_stiffness(matrices, Psi, V0)
    T = np.linalg.solve(A, Q)
    V1 = shear_warping(solver, matrices, Psi, V0, T)
    G_inverse, B = shear_compliance(matrices, Psi, V0, V1, A, T)
    G = np.linalg.inv(G_inverse)
    F = -B.T @ T @ G
    K = np.empty((6, 6))
    K[np.ix_(CLASSICAL, CLASSICAL)] = A + F @ G_inverse @ F.T
    K[np.ix_(CLASSICAL, SHEAR)] = F
    K[np.ix_(SHEAR, CLASSICAL)] = F.T
    K[np.ix_(SHEAR, SHEAR)] = G
    K = 0.5 * (K + K.T)
    scale = 1.0 / np.sqrt(np.abs(np.diag(K)))
    if not np.linalg.eigvalsh(K * np.outer(scale, scale))[0] > 0.0:
        raise SectionError("the stiffness of the section is not positive definite")
    return SectionStiffness(K, A, V0, V1)


def shear_centre(K: Array) -> Array:
    """(x2, x3) where a shear force does not twist the beam, (2,) [m]."""
    S = np.linalg.inv(K)
    return np.array([-S[3, 2], S[3, 1]]) / S[3, 3]


def tension_centre(K: Array) -> Array:
    """(x2, x3) where an axial force does not bend the beam, (2,) [m]."""
    S = np.linalg.inv(K)
    # a force F1 at (y, z) brings M2 = z F1 and M3 = -y F1; kappa2 = kappa3 = 0
    M2, M3 = np.linalg.solve(S[4:, 4:], -S[4:, 0])
    return np.array([-M3, M2])
