"""Closed forms of what the walls of a thin cross-section do that a beam does not."""

from dataclasses import dataclass

import numpy as np

from ..math.arrays import Array

POISSON = 0.3
FREE = 4.730  # first root of a strip with free edges


@dataclass(frozen=True)
class Walls:
    """Width of the widest wall and least thickness of a cross-section [m]."""

    width: float
    thickness: float
    hinged: bool = True  # at its edges, as walls that meet in corners are; a solid section is free

    @property
    def thin(self) -> bool:
        """True if a shell is a model of the part: walls, or a strip, below a fifth of the width."""
        return self.thickness < 0.2 * self.width


def local_frequency(walls: Walls, K: Array, M: Array, across: float = 1.0) -> float:
    """Return the first frequency [rad/s] of a long wall: (k / b)^2 sqrt(D / (rho t)).

    k = pi for hinged edges, 4.730 for free ones.

    `K`, `M` (6, 6) are those of the section, which have E / rho along the beam; `across` is the
    modulus across the wall over that along it.
    """
    speed = np.sqrt(across * K[0, 0] / M[0, 0])
    bending = speed * walls.thickness / np.sqrt(12.0 * (1.0 - POISSON**2))
    k = np.pi if walls.hinged else FREE
    return float((k / walls.width) ** 2 * bending)


def warping_decay(walls: Walls, K: Array) -> float:
    """Return the length [m] in which restrained warping of a section decays, an upper estimate.

    sqrt(E I b^2 / (4 G J)): that of an I-section, whose flanges of stiffness E I bend about x3.
    """
    least = float(np.linalg.eigvalsh(K[4:, 4:])[0])
    return float(np.sqrt(least * walls.width**2 / (4.0 * K[3, 3])))


def ovalisation(walls: Walls, curvature: float) -> float:
    """Return the relative change of the height of a section of this curvature kappa [1/m].

    (kappa b^2 / t)^2 / 32: the walls of a box carry the radial part of the stresses of bending.
    """
    return float(min(1.0, (curvature * walls.width**2 / walls.thickness) ** 2 / 32.0))
