"""The 6x6 stiffness of a beam of any section, by the exact Saint-Venant energy.

Strains e6 = [gamma11, 2 gamma12, 2 gamma13, kappa1, kappa2, kappa3] with
2 gamma12 = v' - phi3 and 2 gamma13 = w' + phi2; resultants F6 = K e6 =
[F1, F2, F3, M1, M2, M3] with M2 = integral of x3 sigma11 and M3 = -integral of
x2 sigma11, all about the origin of the section axes.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array, is_positive_definite
from ..errors import IllConditioned, SectionError
from ..space.space import SectionSpace
from .warping import (
    ClassicalState,
    WarpingSolver,
    beam_strain_fields,
    classical_warping,
    shear_warping,
)

CLASSICAL = np.array([0, 3, 4, 5])  # extension, twist, bend2, bend3
SHEAR = np.array([1, 2])

# Equilibrium along the beam, M2' = F3 and M3' = -F2: [F1, M1, M2, M3]' = Q [F2, F3].
Q = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])


@dataclass(frozen=True)
class SectionStiffness:
    """Stiffness of a section, with the warping fields."""

    K: Array  # (6, 6), order extension, shear2, shear3, twist, bend2, bend3 [N, N m, N m2]
    A: Array  # (4, 4) classical stiffness
    B: Array  # (4, 4) coupling of the strains with their change along the beam
    T: Array  # (4, 2) change of the classical strains per shear force, e' = T [F2, F3]
    V0: Array  # (n_dof, 4) warping per unit classical strain
    V1: Array  # (n_dof, 2) warping per unit shear force
    solvability: (
        float  # relative work of the warping's loads on rigid motions, 0 except for round-off
    )
    space: SectionSpace  # of V0 and V1
    round_off: Array | None = None  # (6, 6) of K, in its units, None if it is negligible
    doubtful: bool = False  # its condition would be refused without `allow`


def classical_stiffness(space: SectionSpace, state: ClassicalState) -> Array:
    """A (4, 4): [F1, M1, M2, M3] = A [gamma11, kappa1, kappa2, kappa3] without shear force.

    The energy of the classical state, A = Psi' L Psi + V0' H Psi. Paper: Eq. (44), without its
    factor 2, which would give 0.654 of the axial stiffness of an isotropic bar (nu = 0.3).
    """
    A = space.work(state.stress, state.strain)
    return np.asarray(0.5 * (A + A.T))


def shear_compliance(
    space: SectionSpace, solver: WarpingSolver, state: ClassicalState, A: Array, B: Array
) -> tuple[Array, Array, Array]:
    """Compliance G^-1 (2, 2) of pure shear, with T (4, 2) and V1 (n_dof, 2).

    G^-1 = C2 - T' B' A^-1 B T, where C2 is the energy quadratic in the shear forces. Paper:
    Eq. (45), with the missing terms of Psi and -B' A^-1 B. Without them the shear stiffness
    is wrong by an order of magnitude.
    """
    T = np.linalg.solve(A, Q)
    V1, load, within = shear_warping(space, solver, state, T)
    mixed = V1.T @ within
    along = T.T @ space.work(state.change_stress, state.change_strain) @ T
    C2 = V1.T @ load + mixed + mixed.T + along
    BT = B @ T
    compliance = C2 - BT.T @ np.linalg.solve(A, BT)
    return np.asarray(0.5 * (compliance + compliance.T)), T, V1


def stiffness(
    space: SectionSpace,
    solver: WarpingSolver,
    E: sp.csr_matrix,
    C: Array,
    is_enough: Callable[[float], bool] | None = None,
) -> SectionStiffness:
    """The 6x6 stiffness K of a section.

    Paper: Eq. (36), Eq. (41), Eq. (42), Eq. (43), with the blocks X = K[CLASSICAL, CLASSICAL],
    F = K[CLASSICAL, SHEAR] = -B' T G and G = K[SHEAR, SHEAR].

    Parameters
    ----------
    space, solver : of the section's mesh
    E : (n_dof, n_dof) stiffness against warping [Pa]
    C : (c, 1 or q, 6, 6) stiffness of the points, section axes [Pa]
    is_enough : whether the growth of a random load by the factorised E allows to go on

    Raises
    ------
    IllConditioned : it does not.
    SectionError : a load on the warping does work on rigid motions, or K is not positive definite.
    FactorisationError : E has more zero modes than the rigid motions (a disconnected section).
    """
    solver.factorise(E)
    if is_enough is not None and not is_enough(solver.measured_growth()):
        raise IllConditioned
    state = classical_warping(space, solver, C, beam_strain_fields(space))
    A = classical_stiffness(space, state)
    # B = V0' H V0 + Psi' L V0: the classical strains with their change along the beam
    B = space.work(state.strain, state.change_stress)
    G_inverse, T, V1 = shear_compliance(space, solver, state, A, B)
    G = np.linalg.inv(G_inverse)
    F = -B.T @ T @ G
    K = np.empty((6, 6))
    K[np.ix_(CLASSICAL, CLASSICAL)] = A + F @ G_inverse @ F.T
    K[np.ix_(CLASSICAL, SHEAR)] = F
    K[np.ix_(SHEAR, CLASSICAL)] = F.T
    K[np.ix_(SHEAR, SHEAR)] = G
    K = 0.5 * (K + K.T)
    if not is_positive_definite(K):
        raise SectionError("the stiffness of the section is not positive definite")
    return SectionStiffness(K, A, B, T, state.V0, V1, solver.solvability, space)


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
