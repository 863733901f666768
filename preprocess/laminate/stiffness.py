"""Stiffness and mass of a laminate per unit area."""

from typing import NamedTuple

import numpy as np

from ...solver.math.arrays import Array
from .shear import ShearCorrection, corrected
from .stack import Laminate, moments


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
    shear : how the transverse shear stiffness is corrected, see shear.py

    Raises
    ------
    LaminateError : an unknown correction, or factors that are not above 0.
    """
    H = moments(laminate)
    plane = laminate.plane
    A, B, D = (np.einsum("k,kij->ij", H[n], plane) for n in range(3))
    rho = np.array([ply.material.rho for ply in laminate.plies])
    return LaminateStiffness(
        A, B, D, corrected(laminate, shear), laminate.thickness, np.asarray(H @ rho)
    )
