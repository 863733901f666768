"""The 6x6 stiffness of a beam of any section, by the exact Saint-Venant energy; its 6x6 mass.

Strains e6 = [gamma11, 2 gamma12, 2 gamma13, kappa1, kappa2, kappa3] with
2 gamma12 = v' - phi3 and 2 gamma13 = w' + phi2; resultants F6 = K e6 =
[F1, F2, F3, M1, M2, M3] with M2 = integral of x3 sigma11 and M3 = -integral of
x2 sigma11, all about the origin of the section axes.

Displacement of a section = rigid motion + V0 e + V1 e' with the classical strains
e = [gamma11, kappa1, kappa2, kappa3] of the beam. The columns of V0 and V1 are nodal values of the
warping. Paper: Eq. (37), Eq. (38).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, is_positive_definite
from .section_specification import IllConditioned, SectionError
from .space.space import SectionSpace
from .warping import WarpingSolver, check_origin, motions_of_beam

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


def beam_strain_fields(space: SectionSpace) -> Array:
    """Psi (n_dof, 4): the strain of point (x2, x3) without warping is G_l Psi e.

    Columns e1, (0, -x3, x2), x3 e1, -x2 e1 for e = [gamma11, kappa1, kappa2, kappa3]: the
    derivative along the beam of the rigid motion of its sections.
    """
    return motions_of_beam(space)[:, CLASSICAL]


@dataclass(frozen=True)
class ClassicalState:
    """Strains and stresses of the points under unit classical strains, each (c, q, 6, 4).

    The beam strain e gives the strain (G_h V0 + G_l Psi) e of a point, and a change e' adds
    G_l V0 e'.
    """

    V0: Array  # (n_dof, 4)
    strain: Array  # G_h V0 + G_l Psi
    stress: Array  # C strain
    change_strain: Array  # G_l V0
    change_stress: Array  # C G_l V0
    C: Array  # (c, 1 or q, 6, 6)


def _product(space: SectionSpace, C: Array) -> Callable[[Array], Array]:
    return lambda W: space.load_in_section(C @ space.strain_in_section(W))


def classical_warping(
    space: SectionSpace, solver: WarpingSolver, C: Array, Psi: Array
) -> ClassicalState:
    """V0 (n_dof, 4): warping per unit classical strain, from E V0 = -H Psi.

    Paper: Eq. (39), corrected: "D" is the identity, and the projection onto the rigid
    fields is zero because H Psi does no work on them.

    Parameters
    ----------
    space : of the warping
    solver : with the factorised E of C
    C : (c, 1 or q, 6, 6) stiffness at the points [Pa]
    Psi : (n_dof, 4) displacements per unit classical strain
    """
    rigid = space.strain_along_beam(Psi)
    load = -space.load_in_section(C @ rigid)
    V0 = solver.solve(load, float(np.linalg.norm(load)), _product(space, C))
    strain = space.strain_in_section(V0) + rigid
    change = space.strain_along_beam(V0)
    return ClassicalState(V0, strain, C @ strain, change, C @ change, C)


def shear_warping(
    space: SectionSpace, solver: WarpingSolver, state: ClassicalState, T: Array
) -> tuple[Array, Array, Array]:
    """V1 (n_dof, 2): warping per unit shear force [F2, F3], and the two parts of its load.

    E V1 = (H' V0 + L Psi - H V0) T: the stresses of the classical state change along the beam by
    e' = T [F2, F3], and so does its warping. Paper: Eq. (40), per shear force instead of per e'.
    With the e' that satisfies equilibrium, the load does no work on rigid motions, so
    the projection is not needed.

    Parameters
    ----------
    space : of the warping
    solver : with the factorised E
    state : strains and stresses of V0
    T : (4, 2) change of the classical strains along the beam per unit shear force

    Returns
    -------
    V1, the load, and its part H V0 T, each (n_dof, 2).
    """
    along = space.load_along_beam(state.stress @ T)
    within = space.load_in_section(state.change_stress @ T)
    size = float(np.linalg.norm(along) + np.linalg.norm(within))
    V1 = solver.solve(along - within, size, _product(space, state.C))
    return V1, along - within, within


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

    Parameters
    ----------
    space : of the warping
    solver : with the factorised E
    state : strains and stresses of V0
    A, B : (4, 4) classical stiffness, and work of the stresses on changes along the beam
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
    check_origin(space, solver.rigid_gram)
    state = classical_warping(space, solver, C, beam_strain_fields(space))
    A = classical_stiffness(space, state)
    check_origin(space, A)
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


def scaled(difference: Array, K: Array) -> Array:
    """Entries in units of sqrt(K_ii K_jj), (6, 6): relative errors in any unit of length."""
    size = np.sqrt(np.abs(np.diag(K)))
    return np.abs(difference) / np.outer(size, size)


def mass_matrix(space: SectionSpace, density: Array) -> Array:
    """Mass per length M (6, 6): kinetic energy v' M v / 2 per metre.

    Parameters
    ----------
    space : the section's integration points
    density : (c, q) at the points [kg/m3]

    Returns
    -------
    (6, 6) for the velocities v = [v1, v2, v3, w1, w2, w3] of the origin of the section axes
    [kg/m, kg, kg m].
    """
    x2, x3 = np.moveaxis(space.points, -1, 0)
    rigid = np.zeros((*x2.shape, 3, 6), dtype=np.result_type(x2, density))  # velocity of a point
    rigid[..., [0, 1, 2], [0, 1, 2]] = 1.0
    rigid[..., 0, 4], rigid[..., 0, 5] = x3, -x2
    rigid[..., 1, 3], rigid[..., 2, 3] = -x3, x2
    columns = rigid.reshape(-1, 6)
    weights = np.repeat((density * space.weights).ravel(), 3)
    M = columns.T @ (weights[:, None] * columns)
    return np.asarray(0.5 * (M + M.T))


def mass_centre(M: Array) -> Array:
    """(x2, x3) of the mass centre, (2,) [m]; the origin if there is no mass."""
    if M[0, 0] == 0.0:
        return np.zeros(2)
    return np.array([-M[0, 5], M[0, 4]]) / M[0, 0]
