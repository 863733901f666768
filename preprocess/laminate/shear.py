"""Transverse shear stiffness of a laminate: corrections of the constant shear strain.

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

from collections.abc import Callable, Sequence

import numpy as np

from ...solver.errors import did_you_mean
from ...solver.math.arrays import Array
from .stack import Laminate, LaminateError, moments

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
    b, d = _bending_compliance(laminate)
    constant, linear = driven(laminate.plane @ b), driven(laminate.plane @ d)
    return -_from_bottom(laminate, constant, linear, height)


def _bending_compliance(laminate: Laminate) -> tuple[Array, Array]:
    """Strain and curvature per unit moment without normal force, (3, 3) [1/N, 1/(N m)]."""
    plane, H = laminate.plane, moments(laminate)
    A, B, D = (np.einsum("k,kij->ij", H[n], plane) for n in range(3))
    d = np.linalg.inv(D - B @ np.linalg.solve(A, B))
    return -np.linalg.solve(A, B) @ d, d


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
