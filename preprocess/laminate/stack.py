"""The plies of a laminate and their positions."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...solver.math.arrays import Array
from ..materials import Orthotropic, ply_rotation, rotated

PLANE = np.array([0, 1, 5])  # 11, 22, 12 of a stress column 11 22 33 23 13 12
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
        thickness = [ply.thickness for ply in self.plies]
        # measured from the middle, so that symmetric plies are symmetric to the last digit
        up, down = np.cumsum([0.0, *thickness]), np.cumsum([0.0, *thickness[::-1]])[::-1]
        return 0.5 * (up - down) + self.offset

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


def moments(laminate: Laminate) -> Array:
    """H_1, H_2, H_3 of every ply: integrals of 1, z, z^2 over it, (3, k) [m, m2, m3].

    Paper: Eq. (30), with the limits h_l and h_(l+1) of its right side.
    """
    z = laminate.faces
    thickness, middle = np.array([ply.thickness for ply in laminate.plies]), 0.5 * (z[1:] + z[:-1])
    # equal to (h_(l+1)^n - h_l^n) / n, without the difference of nearly equal numbers
    return np.stack([thickness, thickness * middle, thickness * (middle**2 + thickness**2 / 12.0)])
