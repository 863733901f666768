"""Closed forms of what the walls of a thin cross-section do that a beam does not."""

from dataclasses import dataclass

import numpy as np

from ..math.arrays import Array

POISSON = 0.3
DECAY = 0.3  # of the width: length in which warping decays along a beam
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


def walls_carried(ratio: float) -> float:
    """Return the relative change of a frequency f because walls vibrate with it.

    x^2 / (1 - x^2) / 10, x = f / f_wall (`ratio`); 1 from the frequency of the walls on. A wall
    that is moved by its edges moves by 1 / (1 - x^2); a tenth of it is the share of shells of
    boxes: about half of the mass is in walls across, and their edges are no hinges.
    """
    x2 = ratio**2
    return min(1.0, 0.1 * x2 / (1.0 - x2)) if x2 < 1.0 else 1.0


def warping_decay(walls: Walls, K: Array) -> float:
    """Return the length [m] in which restrained warping of a section decays, an upper estimate.

    sqrt(E I b^2 / (4 G J)): that of an I-section, whose flanges of stiffness E I bend about x3.
    """
    least = float(np.linalg.eigvalsh(K[4:, 4:])[0])
    return float(np.sqrt(least * walls.width**2 / (4.0 * K[3, 3])))


def ovalisation(walls: Walls, curvature: float, across: float = 1.0) -> float:
    """Return the relative loss of bending stiffness of a section of this curvature kappa [1/m].

    The stresses of bending press the walls towards the neutral axis. A square box loses
    (kappa b^2 / t)^2 / 12.6 of its stiffness, a tube of diameter b as much by Brazier's
    3/2 (1 - nu^2) (kappa R^2 / t)^2. `across` is as in `local_frequency`. A flat strip only loses
    its curvature across (Lamb, Searle): nu^2 (kappa b^2 / t)^2 / 30, at most nu^2 / (1 - nu^2).
    """
    square = (curvature * walls.width**2 / walls.thickness) ** 2 / across
    if walls.hinged:
        return float(min(1.0, square / 12.0))
    return float(min(POISSON**2 / (1.0 - POISSON**2), POISSON**2 * square / 30.0))


def short_waves(walls: Walls, held: float, half_wave: float) -> float:
    """Return the relative change of a frequency because the warping varies along the beam.

    d / (2 d_w) x^2 / (1 + x^2), x = pi d_w / l: warping that a beam takes as that of a uniform
    load varies with the half wave l, and is restrained in part. d_w, the length in which the
    warping decays, is about 0.3 b: between 0.23 b (torsion of a strip) and 0.4 b (its bending).

    Parameters
    ----------
    held : d, the length that a held end takes from the beam under this load [m]
    half_wave : l [m]
    """
    decay = DECAY * walls.width
    x2 = (np.pi * decay / half_wave) ** 2
    return float(min(1.0, 0.5 * held / decay * x2 / (1.0 + x2)))
