"""Laminates: plies, stiffness and mass per unit area, transverse shear, stress in the plies.

First-order theory assumes constant (gxz, gyz) over the thickness. The shear stress in equilibrium
with bending is not constant, and is zero on the faces. A correction is a name or two factors:

    "energy-1d"   default. Shear energy of cylindrical bending, in e1 and e2 separately
                  (Whitney 1973; Vlachoutsis 1992): k_i = R^2 / (d I) with R = int E (z - z_n)^2 dz,
                  d = int G dz, I = int g^2 / G dz, g = -int E (s - z_n) ds from the bottom to z,
                  E = Q_ii and z_n the neutral plane. 5/6 for any one material, and for [a/-a].
    "energy-2x2"  shear energy of the stress in equilibrium of the plies, both
                  directions together (Batoz and Lardeur 1989): a full matrix, with the off-diagonal
                  term that [45/-45]s has. The moment gradients that do no work on T are 0:
                  each of the two terms in T gets half of it.
    "5/6"         the factor of a homogeneous plate; far too stiff for a sandwich.
    [k1, k2]      given factors for gxz and gyz.

With factors, Ds_ij = sqrt(k_i k_j) sum G_ij H_1.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...solver.errors import did_you_mean
from ...solver.math.arrays import Array
from ...solver.package.common.materials import Orthotropic, bond, ply_rotation, rotated
from ...solver.package.shell.plies import PLANE, faces, moments

ACROSS = np.array([4, 3])  # 13, 23: in the order of the shear strains (gxz, gyz)


class LaminateError(Exception):
    """The description of a laminate is wrong."""


@contextmanager
def computed(where: str) -> Iterator[None]:
    """Raise LaminateError for a stiffness that is singular to rounding; `where` is its key."""
    try:
        yield
    except np.linalg.LinAlgError as error:
        raise LaminateError(
            f"{where}: its stiffness is singular to rounding; the moduli, thicknesses and offset "
            "of its plies differ too much in size"
        ) from error


class Lamina(NamedTuple):
    """One ply: its material, its fibre direction [deg] and its thickness [m]."""

    material: Orthotropic
    angle_deg: float
    thickness: float


@dataclass(frozen=True)
class Laminate:
    """Plies from BOTTOM to TOP on a reference surface.

    `offset` [m] is z of the laminate's mid-plane above the reference surface, along e3: 0 if the
    mesh is the mid-surface, +h/2 if it is the bottom face, -h/2 if it is the top face. Raises
    LaminateError without plies, or if a thickness is not above 0.
    """

    plies: tuple[Lamina, ...]
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not self.plies:
            raise LaminateError("a laminate without plies: expected at least one")
        for i, ply in enumerate(self.plies):
            if not (ply.thickness > 0.0 and math.isfinite(ply.thickness)):
                raise LaminateError(
                    f"plies[{i}].thickness = {ply.thickness!r} m: expected a number above 0"
                )
            if not math.isfinite(ply.angle_deg):
                raise LaminateError(f"plies[{i}].angle_deg = {ply.angle_deg!r}: expected a number")
        if not math.isfinite(self.offset):
            raise LaminateError(f"offset = {self.offset!r} m: expected a number")

    @property
    def thickness(self) -> float:
        """Sum of all plies [m]."""
        return float(sum(ply.thickness for ply in self.plies))

    @cached_property
    def faces(self) -> Array:
        """Height z of the faces of the plies from the bottom up, (k + 1,) [m]."""
        return faces([ply.thickness for ply in self.plies], self.offset)

    @cached_property
    def moments(self) -> Array:
        """H_1, H_2, H_3 of every ply: integrals of 1, z, z^2 over it, (3, k) [m, m2, m3]."""
        return moments([ply.thickness for ply in self.plies], self.offset)

    @cached_property
    def stiffness(self) -> Array:
        """Stiffness of each ply in laminate axes, (k, 6, 6) [Pa]."""
        known: dict[tuple[Orthotropic, float], Array] = {}
        for material, angle, _ in self.plies:
            if (material, angle) not in known:
                known[material, angle] = rotated(material.stiffness_M, ply_rotation(angle))
        return np.array([known[ply.material, ply.angle_deg] for ply in self.plies])

    @cached_property
    def plane(self) -> Array:
        """Stiffness of each ply in plane stress, (k, 3, 3) [Pa].

        sigma_33 = 0 eliminates eps_33; (29) does not state this. The coefficients c_11 .. c_66 of
        (18) alone would imply eps_33 = 0 and be too stiff.
        """
        C = self.stiffness
        normal = C[:, PLANE, 2]
        return C[:, PLANE[:, None], PLANE] - (
            normal[:, :, None] * normal[:, None, :] / C[:, 2, 2, None, None]
        )

    @cached_property
    def across(self) -> Array:
        """Transverse shear stiffness of each ply for (gxz, gyz), (k, 2, 2) [Pa]."""
        return self.stiffness[:, ACROSS[:, None], ACROSS]


ShearCorrection = str | Sequence[float]
CORRECTIONS = ("energy-1d", "5/6", "energy-2x2")
HOMOGENEOUS = 5.0 / 6.0

# Three points per ply integrate the square of a quadratic stress exactly.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)
_HEIGHTS, _SHARES = 0.5 * (1.0 + _POINTS), 0.5 * _WEIGHTS


def corrected(laminate: Laminate, shear: ShearCorrection) -> Array:
    """Transverse shear stiffness for (gxz, gyz), (2, 2) [N/m]; positive definite.

    Raises LaminateError for an unknown name, or factors that are not two numbers above 0.
    """
    if isinstance(shear, str) and shear == "energy-2x2":
        return energy_2x2(laminate)
    k = np.sqrt(shear_factors(laminate, shear))
    return np.outer(k, k) * uncorrected(laminate)


def shear_factors(laminate: Laminate, shear: ShearCorrection) -> Array:
    """Factors k_1, k_2 of a correction, (2,) [-]; for "energy-2x2" those of the diagonal."""
    if not isinstance(shear, str):
        return _own(shear)
    if shear == "5/6":
        return np.full(2, HOMOGENEOUS)
    if shear == "energy-1d":
        return energy_1d(laminate)
    if shear == "energy-2x2":
        return np.diag(energy_2x2(laminate)) / np.diag(uncorrected(laminate))
    raise LaminateError(
        f'shear_correction = "{shear}": expected {", ".join(CORRECTIONS)} or two factors'
        + did_you_mean(shear, CORRECTIONS)
    )


def uncorrected(laminate: Laminate) -> Array:
    """Sum of the shear stiffness of the plies, (2, 2) [N/m]. Paper: Eq. (29)."""
    thickness = np.array([ply.thickness for ply in laminate.plies])
    return np.einsum("k,kij->ij", thickness, laminate.across)


def energy_1d(laminate: Laminate) -> Array:
    """Factors of cylindrical bending about each axis, (2,) [-]; see the top of this file."""
    thickness, faces = np.diff(laminate.faces), laminate.faces
    z = faces[:-1, None] + thickness[:, None] * _HEIGHTS
    dz = thickness[:, None] * _SHARES
    factors = np.empty(2)
    for i in range(2):
        E, G = laminate.plane[:, i, i], laminate.across[:, i, i]
        neutral = np.sum(E[:, None] * z * dz) / np.sum(E[:, None] * dz)
        g = -_from_bottom(laminate, -E * neutral, E, _HEIGHTS)
        R, d = np.sum(E[:, None] * (z - neutral) ** 2 * dz), np.sum(G * thickness)
        factors[i] = R**2 / (d * np.sum(g**2 / G[:, None] * dz))
    return factors


def energy_2x2(laminate: Laminate) -> Array:
    """Inverse of the compliance of the equilibrium shear stress, (2, 2) [N/m]."""
    dz = np.diff(laminate.faces)[:, None] * _SHARES
    tau = equilibrium_shear(laminate, _HEIGHTS, _shared)
    energy = np.swapaxes(tau, -1, -2) @ np.linalg.inv(laminate.across)[:, None] @ tau
    Ds = np.linalg.inv(np.einsum("kq,kqij->ij", dz, energy))
    return np.asarray(0.5 * (Ds + Ds.T))


def _cylindrical(S: Array) -> Array:
    """Part of the stress per unit moment (..., 3, 3) due to T with T = (Mx,x ; My,y)."""
    first = [S[..., 0, 0], S[..., 2, 1]]
    second = [S[..., 2, 0], S[..., 1, 1]]
    return np.stack([np.stack(first, axis=-1), np.stack(second, axis=-1)], axis=-2)


def equilibrium_shear(
    laminate: Laminate, height: Array, driven: Callable[[Array], Array] = _cylindrical
) -> Array:
    """Shear stress (xz, yz) per unit T in equilibrium with bending, (k, q, 2, 2) [1/m].

    tau = -int (sigma_x,x + sigma_xy,y ; sigma_xy,x + sigma_y,y) dz with sigma = S(z) M at N = 0.
    Of the gradients of M only T = (Mx,x + Mxy,y ; Mxy,x + My,y) is known. Cylindrical bending,
    the default, assigns all of T to Mx,x and My,y. The stress is zero on both faces and continuous
    between plies, and its integral is T.

    Parameters
    ----------
    height : (q,) places in every ply, from 0 at its bottom to 1 at its top [-]
    driven : assigns T to the gradients of M
    """
    # strain and curvature per unit moment without normal force [1/N, 1/(N m)]
    A, B, D = (np.einsum("k,kij->ij", H, laminate.plane) for H in laminate.moments)
    d = np.linalg.inv(D - B @ np.linalg.solve(A, B))
    b = -np.linalg.solve(A, B) @ d
    constant, linear = driven(laminate.plane @ b), driven(laminate.plane @ d)
    return -_from_bottom(laminate, constant, linear, height)


def _shared(S: Array) -> Array:
    """As `_cylindrical`, with half of each component of T in each of its two terms."""
    first = [S[..., 0, 0] + S[..., 2, 2], S[..., 0, 2] + S[..., 2, 1]]
    second = [S[..., 2, 0] + S[..., 1, 2], S[..., 2, 2] + S[..., 1, 1]]
    return 0.5 * np.stack([np.stack(first, axis=-1), np.stack(second, axis=-1)], axis=-2)


def _from_bottom(laminate: Laminate, constant: Array, linear: Array, height: Array) -> Array:
    """Integral of constant + z linear from the bottom face of the laminate, (k, q, ...).

    Parameters
    ----------
    constant, linear : (k, ...) of each ply
    height : (q,) places in every ply, from 0 at its bottom to 1 at its top [-]
    """
    faces, thickness = laminate.faces, np.diff(laminate.faces)
    inner = (1,) * (constant.ndim - 1)

    def in_ply(height: Array) -> Array:
        s = thickness[:, None] * height
        mean = (faces[:-1, None] + 0.5 * s).reshape(*s.shape, *inner)
        return np.asarray(
            s.reshape(*s.shape, *inner) * (constant[:, None] + mean * linear[:, None])
        )

    plies = in_ply(np.ones(1))
    return np.asarray(np.cumsum(plies, axis=0) - plies + in_ply(height))


def _own(factors: Sequence[float]) -> Array:
    try:
        k = np.array([float(value) for value in factors])
    except (TypeError, ValueError):
        k = np.empty(0)
    if k.shape != (2,) or not np.all((k > 0.0) & np.isfinite(k)):
        raise LaminateError(
            f"shear_correction = {factors!r}: expected {', '.join(CORRECTIONS)}, or two factors "
            "above 0"
        )
    return k


class LaminateStiffness(NamedTuple):
    """N = A e + B k, M = B e + D k, T = Ds gamma in laminate axes; the mass about z = 0."""

    A: Array  # (3, 3) membrane                                             [N/m]
    B: Array  # (3, 3) coupling, symmetric                                  [N]
    D: Array  # (3, 3) bending                                              [N m]
    Ds: Array  # (2, 2) transverse shear, corrected                         [N/m]
    thickness: float  # [m]
    mass: Array  # (3,) density times 1, z, z^2 over the thickness          [kg/m2, kg/m, kg]

    @property
    def ABD(self) -> Array:
        """[[A, B], [B, D]], (6, 6) [N/m, N, N m]."""
        return np.block([[self.A, self.B], [self.B, self.D]])


def laminate_stiffness(
    laminate: Laminate, shear: ShearCorrection = "energy-1d"
) -> LaminateStiffness:
    """Sum the plies of a laminate. Paper: Eq. (28), Eq. (29), Eq. (30).

    H_n integrates z^(n-1) over a ply: H_1 goes with A, H_2 with the coupling B and H_3 with D;
    (29) interchanges the last two.

    Parameters
    ----------
    laminate : plies from bottom to top
    shear : how the transverse shear stiffness is corrected, see the top of this file

    Raises
    ------
    LaminateError : an unknown correction, or factors that are not above 0.
    """
    H = laminate.moments
    plane = laminate.plane
    A, B, D = (np.einsum("k,kij->ij", H[n], plane) for n in range(3))
    rho = np.array([ply.material.rho for ply in laminate.plies])
    return LaminateStiffness(
        A, B, D, corrected(laminate, shear), laminate.thickness, np.asarray(H @ rho)
    )


LEVELS = ("bottom", "middle", "top")
_AT_LEVELS = np.array([0.0, 0.5, 1.0])


def stress_operators(laminate: Laminate) -> Array:
    """Stress of every ply at bottom, middle and top per unit resultant, (k, 3, 6, 8).

    Columns N (3) [Pa/(N/m)], M (3) [Pa/N], T (2) [Pa/(N/m)] in laminate axes; rows 11, 22, 33,
    23, 13, 12 in the axes of the ply. The transverse shear stress follows from equilibrium of
    the plies, not from the constant strain of the theory. It is continuous and zero on the faces.
    """
    stiffness = laminate_stiffness(laminate)
    compliance = np.linalg.inv(stiffness.ABD)
    at = strain_stress_at(laminate, _AT_LEVELS)
    at[..., :6] = at[..., :6] @ compliance
    return at


def strain_stress_at(laminate: Laminate, height: Array) -> Array:
    """Stress in ply axes per unit e [Pa], k [Pa m] and T [1/m], (k, q, 6, 8).

    Parameters
    ----------
    height : (q,) places in every ply, from 0 at its bottom to 1 at its top [-]
    """
    faces = laminate.faces
    z = faces[:-1, None] + np.diff(faces)[:, None] * height
    plane, tau = laminate.plane[:, None], equilibrium_shear(laminate, height)
    stress_E = np.zeros((*z.shape, 6, 8))
    stress_E[..., PLANE, :3] = plane
    stress_E[..., PLANE, 3:6] = z[..., None, None] * plane
    stress_E[..., ACROSS, 6:] = tau
    A_EM = np.array([ply_rotation(ply.angle_deg) for ply in laminate.plies])
    T_ME = bond(np.swapaxes(A_EM, -1, -2))
    return np.asarray(T_ME[:, None] @ stress_E)
